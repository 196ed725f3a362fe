// The GL functions that the runtime calls, loaded through the caller's getProcAddress.
#pragma once

#include <GL/glcorearb.h>

#include <functional>
#include <string>

// Functions that OpenGL core 4.5 and OpenGL ES 3.2 have under one name.
#define PELAGE_GL_COMMON_FUNCTIONS(X)                                          \
  X(PFNGLACTIVETEXTUREPROC, glActiveTexture)                                   \
  X(PFNGLATTACHSHADERPROC, glAttachShader)                                     \
  X(PFNGLBEGINQUERYPROC, glBeginQuery)                                         \
  X(PFNGLBINDBUFFERPROC, glBindBuffer)                                         \
  X(PFNGLBINDBUFFERBASEPROC, glBindBufferBase)                                 \
  X(PFNGLBINDBUFFERRANGEPROC, glBindBufferRange)                               \
  X(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)                               \
  X(PFNGLBINDRENDERBUFFERPROC, glBindRenderbuffer)                             \
  X(PFNGLBINDSAMPLERPROC, glBindSampler)                                       \
  X(PFNGLBINDTEXTUREPROC, glBindTexture)                                       \
  X(PFNGLBINDVERTEXARRAYPROC, glBindVertexArray)                               \
  X(PFNGLBINDVERTEXBUFFERPROC, glBindVertexBuffer)                             \
  X(PFNGLBLENDEQUATIONPROC, glBlendEquation)                                   \
  X(PFNGLBLENDEQUATIONSEPARATEIPROC, glBlendEquationSeparatei)                 \
  X(PFNGLBLENDFUNCPROC, glBlendFunc)                                           \
  X(PFNGLBLENDFUNCSEPARATEIPROC, glBlendFuncSeparatei)                         \
  X(PFNGLBLITFRAMEBUFFERPROC, glBlitFramebuffer)                               \
  X(PFNGLBUFFERDATAPROC, glBufferData)                                         \
  X(PFNGLBUFFERSUBDATAPROC, glBufferSubData)                                   \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, glCheckFramebufferStatus)                 \
  X(PFNGLCLEARBUFFERFVPROC, glClearBufferfv)                                   \
  X(PFNGLCOLORMASKPROC, glColorMask)                                           \
  X(PFNGLCOLORMASKIPROC, glColorMaski)                                         \
  X(PFNGLCOMPILESHADERPROC, glCompileShader)                                   \
  X(PFNGLCOPYBUFFERSUBDATAPROC, glCopyBufferSubData)                           \
  X(PFNGLCREATEPROGRAMPROC, glCreateProgram)                                   \
  X(PFNGLCREATESHADERPROC, glCreateShader)                                     \
  X(PFNGLDEBUGMESSAGECALLBACKPROC, glDebugMessageCallback)                     \
  X(PFNGLDEBUGMESSAGECONTROLPROC, glDebugMessageControl)                       \
  X(PFNGLDELETEBUFFERSPROC, glDeleteBuffers)                                   \
  X(PFNGLDELETEFRAMEBUFFERSPROC, glDeleteFramebuffers)                         \
  X(PFNGLDELETEPROGRAMPROC, glDeleteProgram)                                   \
  X(PFNGLDELETEQUERIESPROC, glDeleteQueries)                                   \
  X(PFNGLDELETERENDERBUFFERSPROC, glDeleteRenderbuffers)                       \
  X(PFNGLDELETESHADERPROC, glDeleteShader)                                     \
  X(PFNGLDELETETEXTURESPROC, glDeleteTextures)                                 \
  X(PFNGLDELETEVERTEXARRAYSPROC, glDeleteVertexArrays)                         \
  X(PFNGLDEPTHFUNCPROC, glDepthFunc)                                           \
  X(PFNGLDEPTHMASKPROC, glDepthMask)                                           \
  X(PFNGLDEPTHRANGEFPROC, glDepthRangef)                                       \
  X(PFNGLDISABLEPROC, glDisable)                                               \
  X(PFNGLDISABLEVERTEXATTRIBARRAYPROC, glDisableVertexAttribArray)             \
  X(PFNGLDISABLEIPROC, glDisablei)                                             \
  X(PFNGLDISPATCHCOMPUTEPROC, glDispatchCompute)                               \
  X(PFNGLDISPATCHCOMPUTEINDIRECTPROC, glDispatchComputeIndirect)               \
  X(PFNGLDRAWARRAYSINDIRECTPROC, glDrawArraysIndirect)                         \
  X(PFNGLDRAWARRAYSINSTANCEDPROC, glDrawArraysInstanced)                       \
  X(PFNGLDRAWELEMENTSINSTANCEDPROC, glDrawElementsInstanced)                   \
  X(PFNGLENABLEPROC, glEnable)                                                 \
  X(PFNGLENABLEVERTEXATTRIBARRAYPROC, glEnableVertexAttribArray)               \
  X(PFNGLENABLEIPROC, glEnablei)                                               \
  X(PFNGLFINISHPROC, glFinish)                                                 \
  X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, glFramebufferRenderbuffer)               \
  X(PFNGLFRAMEBUFFERTEXTURE2DPROC, glFramebufferTexture2D)                     \
  X(PFNGLGENBUFFERSPROC, glGenBuffers)                                         \
  X(PFNGLGENFRAMEBUFFERSPROC, glGenFramebuffers)                               \
  X(PFNGLGENQUERIESPROC, glGenQueries)                                         \
  X(PFNGLGENRENDERBUFFERSPROC, glGenRenderbuffers)                             \
  X(PFNGLGENTEXTURESPROC, glGenTextures)                                       \
  X(PFNGLGENVERTEXARRAYSPROC, glGenVertexArrays)                               \
  X(PFNGLGETBOOLEANI_VPROC, glGetBooleani_v)                                   \
  X(PFNGLGETBOOLEANVPROC, glGetBooleanv)                                       \
  X(PFNGLGETBUFFERPARAMETERI64VPROC, glGetBufferParameteri64v)                 \
  X(PFNGLGETERRORPROC, glGetError)                                             \
  X(PFNGLGETFLOATVPROC, glGetFloatv)                                           \
  X(PFNGLGETINTEGER64I_VPROC, glGetInteger64i_v)                               \
  X(PFNGLGETINTEGER64VPROC, glGetInteger64v)                                   \
  X(PFNGLGETINTEGERI_VPROC, glGetIntegeri_v)                                   \
  X(PFNGLGETINTEGERVPROC, glGetIntegerv)                                       \
  X(PFNGLGETINTERNALFORMATIVPROC, glGetInternalformativ)                       \
  X(PFNGLGETPROGRAMBINARYPROC, glGetProgramBinary)                             \
  X(PFNGLGETPROGRAMINFOLOGPROC, glGetProgramInfoLog)                           \
  X(PFNGLGETPROGRAMINTERFACEIVPROC, glGetProgramInterfaceiv)                   \
  X(PFNGLGETPROGRAMRESOURCENAMEPROC, glGetProgramResourceName)                 \
  X(PFNGLGETPROGRAMRESOURCEIVPROC, glGetProgramResourceiv)                     \
  X(PFNGLGETPROGRAMIVPROC, glGetProgramiv)                                     \
  X(PFNGLGETQUERYOBJECTUIVPROC, glGetQueryObjectuiv)                           \
  X(PFNGLGETQUERYIVPROC, glGetQueryiv)                                         \
  X(PFNGLGETSHADERINFOLOGPROC, glGetShaderInfoLog)                             \
  X(PFNGLGETSHADERIVPROC, glGetShaderiv)                                       \
  X(PFNGLGETSTRINGPROC, glGetString)                                           \
  X(PFNGLGETSTRINGIPROC, glGetStringi)                                         \
  X(PFNGLGETUNIFORMIVPROC, glGetUniformiv)                                     \
  X(PFNGLISBUFFERPROC, glIsBuffer)                                             \
  X(PFNGLISENABLEDPROC, glIsEnabled)                                           \
  X(PFNGLISENABLEDIPROC, glIsEnabledi)                                         \
  X(PFNGLLINKPROGRAMPROC, glLinkProgram)                                       \
  X(PFNGLMAPBUFFERRANGEPROC, glMapBufferRange)                                 \
  X(PFNGLMEMORYBARRIERPROC, glMemoryBarrier)                                   \
  X(PFNGLOBJECTLABELPROC, glObjectLabel)                                       \
  X(PFNGLPOPDEBUGGROUPPROC, glPopDebugGroup)                                   \
  X(PFNGLPROGRAMBINARYPROC, glProgramBinary)                                   \
  X(PFNGLPROGRAMPARAMETERIPROC, glProgramParameteri)                           \
  X(PFNGLPUSHDEBUGGROUPPROC, glPushDebugGroup)                                 \
  X(PFNGLREADPIXELSPROC, glReadPixels)                                         \
  X(PFNGLRENDERBUFFERSTORAGEMULTISAMPLEPROC, glRenderbufferStorageMultisample) \
  X(PFNGLSHADERSOURCEPROC, glShaderSource)                                     \
  X(PFNGLTEXPARAMETERIPROC, glTexParameteri)                                   \
  X(PFNGLTEXSTORAGE2DPROC, glTexStorage2D)                                     \
  X(PFNGLTEXSTORAGE3DPROC, glTexStorage3D)                                     \
  X(PFNGLTEXSUBIMAGE2DPROC, glTexSubImage2D)                                   \
  X(PFNGLTEXSUBIMAGE3DPROC, glTexSubImage3D)                                   \
  X(PFNGLUNIFORM4IPROC, glUniform4i)                                           \
  X(PFNGLUNMAPBUFFERPROC, glUnmapBuffer)                                       \
  X(PFNGLUSEPROGRAMPROC, glUseProgram)                                         \
  X(PFNGLVERTEXATTRIBBINDINGPROC, glVertexAttribBinding)                       \
  X(PFNGLVERTEXATTRIBFORMATPROC, glVertexAttribFormat)                         \
  X(PFNGLVERTEXATTRIBIFORMATPROC, glVertexAttribIFormat)                       \
  X(PFNGLVERTEXBINDINGDIVISORPROC, glVertexBindingDivisor)                     \
  X(PFNGLVIEWPORTPROC, glViewport)

// Functions of core 4.5 that OpenGL ES 3.2 does not have; nullptr there.
#define PELAGE_GL_CORE_FUNCTIONS(X)                  \
  X(PFNGLCLIPCONTROLPROC, glClipControl)             \
  X(PFNGLDEPTHRANGEINDEXEDPROC, glDepthRangeIndexed) \
  X(PFNGLGETDOUBLEI_VPROC, glGetDoublei_v)           \
  X(PFNGLGETFLOATI_VPROC, glGetFloati_v)             \
  X(PFNGLPOLYGONMODEPROC, glPolygonMode)             \
  X(PFNGLVIEWPORTINDEXEDFPROC, glViewportIndexedf)

// Timer queries: core 4.5, or with the suffix EXT in GL_EXT_disjoint_timer_query; else nullptr.
#define PELAGE_GL_TIMER_FUNCTIONS(X)                     \
  X(PFNGLGETQUERYOBJECTUI64VPROC, glGetQueryObjectui64v) \
  X(PFNGLQUERYCOUNTERPROC, glQueryCounter)

// From GL_KHR_parallel_shader_compile or, with the suffix ARB, GL_ARB_parallel_shader_compile; else
// nullptr.
#define PELAGE_GL_PARALLEL_FUNCTIONS(X) \
  X(PFNGLMAXSHADERCOMPILERTHREADSKHRPROC, glMaxShaderCompilerThreads)

// Whether the context was reset: core 4.5 and OpenGL ES 3.2, or with the suffix KHR in
// GL_KHR_robustness; else nullptr.
#define PELAGE_GL_ROBUST_FUNCTIONS(X) X(PFNGLGETGRAPHICSRESETSTATUSPROC, glGetGraphicsResetStatus)

namespace pelage::gl {

/// GL_EXT_disjoint_timer_query; OpenGL's own header has no name for it.
inline constexpr GLenum kGpuDisjoint = 0x8FBB;

struct Functions {
#define PELAGE_GL_DECLARE(type, name) type name = nullptr;
  PELAGE_GL_COMMON_FUNCTIONS(PELAGE_GL_DECLARE)
  PELAGE_GL_CORE_FUNCTIONS(PELAGE_GL_DECLARE)
  PELAGE_GL_TIMER_FUNCTIONS(PELAGE_GL_DECLARE)
  PELAGE_GL_PARALLEL_FUNCTIONS(PELAGE_GL_DECLARE)
  PELAGE_GL_ROBUST_FUNCTIONS(PELAGE_GL_DECLARE)
#undef PELAGE_GL_DECLARE
};

using GetProcAddress = std::function<void*(const char*)>;

/// Each loads one group and returns the name of the first function that is not there, or "".
std::string loadCommonFunctions(Functions& gl, const GetProcAddress& getProcAddress);
std::string loadCoreFunctions(Functions& gl, const GetProcAddress& getProcAddress);
std::string loadTimerFunctions(Functions& gl, const GetProcAddress& getProcAddress,
                               const char* suffix);
std::string loadParallelFunctions(Functions& gl, const GetProcAddress& getProcAddress,
                                  const char* suffix);
std::string loadRobustFunctions(Functions& gl, const GetProcAddress& getProcAddress,
                                const char* suffix);

}  // namespace pelage::gl
