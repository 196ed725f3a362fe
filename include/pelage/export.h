// Macros for the symbols that the libraries export. Static libraries, the default, do not need
// them. With the CMake option PELAGE_SHARED (or BUILD_SHARED_LIBS) the targets define PELAGE_SHARED
// for themselves and for programs that link them, and everything without one of these macros is
// hidden.
//
// There is a macro for each library, because on Windows a library imports the symbols of the
// others. Not tested there: the build refuses it, as the tables of generated kernels are not
// marked.
#pragma once

#if !defined(PELAGE_SHARED)
#define PELAGE_EXPORT
#define PELAGE_IMPORT
#elif defined(_WIN32)
#define PELAGE_EXPORT __declspec(dllexport)
#define PELAGE_IMPORT __declspec(dllimport)
#else
#define PELAGE_EXPORT __attribute__((visibility("default")))
#define PELAGE_IMPORT PELAGE_EXPORT
#endif

/// For pelage::core and pelage::passes. CMake defines pelage_core_EXPORTS where it is compiled as a
/// shared library.
#if defined(pelage_core_EXPORTS) || defined(pelage_passes_EXPORTS)
#define PELAGE_API PELAGE_EXPORT
#else
#define PELAGE_API PELAGE_IMPORT
#endif

/// For pelage::vulkan.
#if defined(pelage_vulkan_EXPORTS)
#define PELAGE_VULKAN_API PELAGE_EXPORT
#else
#define PELAGE_VULKAN_API PELAGE_IMPORT
#endif

/// For pelage::gl.
#if defined(pelage_gl_EXPORTS)
#define PELAGE_GL_API PELAGE_EXPORT
#else
#define PELAGE_GL_API PELAGE_IMPORT
#endif

/// For pelage::demo.
#if defined(pelage_demo_EXPORTS)
#define PELAGE_DEMO_API PELAGE_EXPORT
#else
#define PELAGE_DEMO_API PELAGE_IMPORT
#endif
