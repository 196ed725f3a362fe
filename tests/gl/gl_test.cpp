// The OpenGL and OpenGL ES runtime, on core 4.5 and on ES 3.2, where it differs from that of the
// other API (tests/passes). Where codegen's kernels will not do, they are written here, in the
// common subset of both languages.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gl/engine_context.h"
#include "support/errors.h"
#include "support/own_device.h"
#include "support/test_code.h"
#include "support/test_folder.h"
#include "support/texture_list.h"

namespace pelage::test {
namespace {

using testing::Values;

// A kernel with its tables, from one GLSL text.
struct TestKernel {
  std::string name, glsl, essl;
  std::vector<LayoutEntry> entries;
  LayoutTable layout;
  const LayoutTable* layouts[1];
  std::vector<SpecConstant> constants;
  std::vector<VariantBinding> bindings;
  Kernel kernel;
  KernelVariant variant;

  TestKernel(const TestKernel&) = delete;
  TestKernel(std::string name_, Stage stage, const std::string& body,
             std::vector<LayoutEntry> entries_, std::vector<SpecConstant> constants_ = {},
             uint32_t groupSize = 64)
      : name(std::move(name_)),
        glsl("#version 450\n" + body),
        essl("#version 320 es\nprecision highp float;\nprecision highp int;\n" + body),
        entries(std::move(entries_)),
        layout{"Test", "test", 0, entries},
        layouts{&layout},
        constants(std::move(constants_)) {
    for (size_t i = 0; i < entries.size(); ++i)
      if ((entries[i].stages & stageBit(stage)) != 0)
        bindings.push_back({0, static_cast<uint8_t>(i), entries[i].access,
                            static_cast<uint8_t>(entries[i].glBinding)});
    kernel = {name.c_str(), stage, layouts, constants, {}};
    const bool compute = stage == Stage::kCompute;
    variant = {&kernel, "", bindings, {}, freshHash()};
    variant.groupSize[0] = compute ? groupSize : 0;
    variant.groupSize[1] = variant.groupSize[2] = compute ? 1 : 0;
  }

  /// Gives its code to a Runtime or a HeadlessDevice.
  template <class Receiver>
  void addTo(Receiver& receiver) const {
    const KernelCode* const code[] = {makeCode(kernel, CodeFormat::kGlsl, variant.hash, glsl),
                                      makeCode(kernel, CodeFormat::kEssl, variant.hash, essl)};
    receiver.addCode(code);
  }
};

LayoutEntry storage(const char* name, Access access, uint32_t glBinding,
                    StageMask stages = stageBit(Stage::kCompute)) {
  return {name, "uint", ResourceKind::kStorageBuffer, access, stages, 4, glBinding, glBinding};
}

/// A list of one dispatch that writes g_target.
PassList listOf(const TestKernel& kernel, uint32_t threads, BufferId target, uint64_t bytes,
                const std::vector<SpecValue>& values = {}) {
  PassList list;
  expectOk(PassBuilder(list)
               .dispatch(kernel.variant, threads)
               .bind("g_target", target, bytes)
               .spec(values)
               .finish());
  return list;
}

class GlTest : public testing::TestWithParam<Api>, protected OwnDevice {
 protected:
  void SetUp() override { open(GetParam()); }
  void TearDown() override { expectNoMessages(); }
};
INSTANTIATE_TEST_SUITE_P(All, GlTest, Values(Api::kGl, Api::kGles), apiTestName);

constexpr char kSpecialised[] = R"(
#ifndef SPIRV_CROSS_CONSTANT_ID_0
#define SPIRV_CROSS_CONSTANT_ID_0 2u
#endif
const uint kUint = SPIRV_CROSS_CONSTANT_ID_0;
#ifndef SPIRV_CROSS_CONSTANT_ID_1
#define SPIRV_CROSS_CONSTANT_ID_1 -3
#endif
const int kInt = SPIRV_CROSS_CONSTANT_ID_1;
#ifndef SPIRV_CROSS_CONSTANT_ID_10
#define SPIRV_CROSS_CONSTANT_ID_10 false
#endif
const bool kBool = SPIRV_CROSS_CONSTANT_ID_10;
#ifndef SPIRV_CROSS_CONSTANT_ID_3
#define SPIRV_CROSS_CONSTANT_ID_3 0.5
#endif
const float kFloat = SPIRV_CROSS_CONSTANT_ID_3;
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Target { uint g_target[]; };
shared uint table[kUint];
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < kUint) table[i] = i;
  barrier();
  if (i != 0u) return;
  g_target[0] = table[kUint - 1u] + 1u;
  g_target[1] = uint(kInt);
  g_target[2] = kBool ? 1u : 0u;
  g_target[3] = floatBitsToUint(kFloat);
}
)";

TEST_P(GlTest, SetsSpecConstantsOfEveryTypeToTheBit) {
  TestKernel kernel("specialised", Stage::kCompute, kSpecialised,
                    {storage("g_target", Access::kWrite, 0)},
                    {{"kUint", 0, 2},
                     {"kInt", 1, static_cast<uint32_t>(-3)},
                     {"kBool", 10, 0},
                     {"kFloat", 3, 0x3f000000u}});
  kernel.addTo(*device_);
  const BufferId target = addWords("target", 4);
  update();
  const auto run = [&](std::vector<SpecValue> values) {
    PassList list = listOf(kernel, 64, target, 16, values);
    execute(list);
    return read(target);
  };
  const auto minusThree = static_cast<uint32_t>(-3);
  EXPECT_EQ(run({}), (std::vector<uint32_t>{2, minusThree, 0, 0x3f000000u}));
  const uint32_t pi = std::bit_cast<uint32_t>(3.14159274f);
  EXPECT_EQ(run({{0, 31}, {1, 0x80000000u}, {10, 1}, {3, pi}}),
            (std::vector<uint32_t>{31, 0x80000000u, 1, pi}));
  const uint32_t infinity = std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity());
  // A value of a constant that the kernel does not have is somebody else's.
  EXPECT_EQ(run({{3, infinity}, {99, 5}}), (std::vector<uint32_t>{2, minusThree, 0, infinity}));
  EXPECT_EQ(run({}), (std::vector<uint32_t>{2, minusThree, 0, 0x3f000000u}));
}

TEST_P(GlTest, TimesEachPass) {
  TestKernel slow("slow", Stage::kCompute, R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Target { uint g_target[]; };
void main() {
  uint x = g_target[gl_GlobalInvocationID.x];
  for (uint i = 0u; i < 20000u; ++i) x = x * 1664525u + 1013904223u;
  g_target[gl_GlobalInvocationID.x] = x;
}
)",
                  {storage("g_target", Access::kReadWrite, 0)});
  slow.addTo(*device_);
  const BufferId target = addWords("target", 6400);
  const BufferId source = addWords("source", 64);
  update();
  PassList list;
  addAccumulate(list, source, target, 64, 1, 1);
  expectOk(PassBuilder(list).dispatch(slow.variant, 6400).bind("g_target", target, 25600).finish());
  addAccumulate(list, source, target, 64, 1, 1);
  std::vector<PassTiming> timings;
  execute(list, nullptr);  // compiles
  execute(list, &timings);
  ASSERT_EQ(timings.size(), 3u);
  EXPECT_STREQ(timings[0].name, "accumulate");
  EXPECT_STREQ(timings[1].name, "slow");
  for (const PassTiming& timing : timings) {
    EXPECT_TRUE(std::isfinite(timing.milliseconds));
    EXPECT_TRUE(timing.milliseconds >= 0 || timing.milliseconds == -1) << timing.milliseconds;
  }
  if (timings[1].milliseconds >= 0) {
    EXPECT_GT(timings[1].milliseconds, timings[0].milliseconds);
    EXPECT_GT(timings[1].milliseconds, timings[2].milliseconds);
    EXPECT_GT(timings[1].milliseconds, 0);
  }
}

constexpr char kNothing[] = "layout(local_size_x = 64) in;\nvoid main() {}\n";

TEST_P(GlTest, RefusesKernelsThatAreOverTheLimits) {
  const BufferId target = addWords("target", 64);
  update();
  TestKernel wide("wide", Stage::kCompute, kNothing, {storage("g_target", Access::kWrite, 0)}, {},
                  1u << 20);
  wide.addTo(*device_);
  TestKernel far("far", Stage::kCompute, kNothing, {storage("g_target", Access::kWrite, 200)});
  far.addTo(*device_);
  for (const auto& [kernel, word] :
       {std::pair{&wide, "GL_MAX_COMPUTE_WORK_GROUP_SIZE"}, std::pair{&far, "GL binding 200"}}) {
    expectError(device_->execute(listOf(*kernel, 64, target, 256)), ErrorCode::kUnsupported,
                {word, device_->info().name});
  }
}

TEST_P(GlTest, GivesBackTheDriversLogOfABrokenKernel) {
  TestKernel broken("broken", Stage::kCompute, R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Target { uint g_target[]; };
void main() { g_target[0] = not_a_variable; }
)",
                    {storage("g_target", Access::kWrite, 0)});
  broken.addTo(*device_);
  broken.variant.key = "wind=1";
  const BufferId target = addWords("target", 64);
  update();
  expectError(device_->execute(listOf(broken, 64, target, 256)),
              {"broken [wind=1]", "not_a_variable", device_->info().name.c_str()});
  expectedMessages_ = device_->messageCount();  // some drivers count it, some do not
}

TEST_P(GlTest, NamesTheBufferThatDoesNotFitAndCountsTheDriversError) {
  const BufferId good = add("good", ramp(1, 10));
  table_.add({"groom/huge", uint64_t{1} << 50, 4, BufferUsage::kStorage, {}});
  expectError(device_->update(table_), ErrorCode::kOutOfMemory,
              {"groom/huge", "1125899906842624", "GL_OUT_OF_MEMORY"});
  EXPECT_EQ(read(good), ramp(1, 10));  // what fitted is there
  // It is an error in the driver's debug output too, so the counter is not deaf.
  EXPECT_GE(device_->messageCount(), 1u);
  expectedMessages_ = device_->messageCount();
}

TEST_P(GlTest, SaysThatAKernelHasNoSourceForTheApi) {
  const TestKernel kernel("foreign", Stage::kCompute, kNothing,
                          {storage("g_target", Access::kWrite, 0)});
  const KernelCode* const otherApi[] = {
      makeCode(kernel.kernel, GetParam() == Api::kGles ? CodeFormat::kGlsl : CodeFormat::kEssl,
               kernel.variant.hash, kernel.glsl)};
  device_->addCode(otherApi);
  const BufferId target = addWords("target", 64);
  update();
  expectError(device_->execute(listOf(kernel, 64, target, 256)),
              {GetParam() == Api::kGles ? "ESSL" : "GLSL"});
}

TEST(GlDevices, WorkAlternatelyInOneProcess) {
  std::vector<std::unique_ptr<HeadlessDevice>> devices;
  for (const Api api : {Api::kGl, Api::kGles, Api::kGl}) {
    auto device = createHeadlessGl({api, true, -1});
    if (!device) PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
    devices.push_back(std::move(*device));
  }
  for (const auto& device : devices) device->addCode(runtime_test::allCode());
  ResourceTable table;
  std::vector<uint32_t> source = ramp(1, 100), target = ramp(2, 100);
  const BufferId sourceBuffer =
      table.add("source", source, BufferUsage::kStorage | BufferUsage::kUpload);
  const BufferId targetBuffer =
      table.add("target", target, BufferUsage::kStorage | BufferUsage::kUpload);
  for (const auto& device : devices) ASSERT_TRUE(device->update(table));
  std::vector<HazardTracker> trackers(devices.size());
  for (uint32_t frame = 0; frame < 4; ++frame) {
    PassList list;
    addAccumulate(list, sourceBuffer, targetBuffer, 100, 2, frame);
    for (size_t i = 0; i < devices.size(); ++i) {
      // A list runs once.
      PassList copy = list;
      trackers[i].resolve(copy);
      ASSERT_TRUE(devices[i]->execute(copy));
    }
    accumulateOnHost(source, target, 2, frame);
  }
  devices.erase(devices.begin() + 1);  // the others outlive it
  for (const auto& device : devices) {
    const auto bytes = required(device->read(targetBuffer));
    EXPECT_EQ(valuesOf<uint32_t>(*bytes), target);
    EXPECT_EQ(device->messageCount(), 0u);
  }
}

// The runtime on a context of an "engine", which is this test.

class GlRuntimeTest : public GlContextTest {
 protected:
  /// Two buffers of 64 words, and a list that accumulates one of them into the other.
  PassList smallList() {
    buffer_ = addZeros(table_, "buffer", 64);
    other_ = addZeros(table_, "other", 64);
    PassList list;
    addAccumulate(list, buffer_, other_, 64, 1, 1);
    return list;
  }
  /// The runtime has the buffers of the table, too.
  PassList smallList(gl::Runtime& runtime) {
    PassList list = smallList();
    expectOk(runtime.update(table_));
    return list;
  }
  /// As a new list, also where it has run.
  static void record(gl::Runtime& runtime, PassList& list, gl::PassTimer* timer = nullptr) {
    list.run.reset();
    HazardTracker().resolve(list);
    expectOk(runtime.record(list, timer));
  }

  ResourceTable table_;
  BufferId buffer_ = BufferId::kInvalid, other_ = BufferId::kInvalid;
};
INSTANTIATE_TEST_SUITE_P(All, GlRuntimeTest, Values(Api::kGl, Api::kGles), apiTestName);

// The answers of a lesser driver; getProcAddress below hands these out.
std::string g_fakeVersion;
std::map<GLenum, GLint> g_fakeIntegers;
std::string g_missingFunction;

const GLubyte* APIENTRY fakeGetString(GLenum name) {
  if (name == GL_VERSION && !g_fakeVersion.empty())
    return reinterpret_cast<const GLubyte*>(g_fakeVersion.c_str());
  return glFunction<PFNGLGETSTRINGPROC>("glGetString")(name);
}
void APIENTRY fakeGetIntegerv(GLenum name, GLint* value) {
  const auto fake = g_fakeIntegers.find(name);
  if (fake != g_fakeIntegers.end()) {
    *value = fake->second;
  } else {
    glFunction<PFNGLGETINTEGERVPROC>("glGetIntegerv")(name, value);
  }
}
// Calls of the runtime in this order: 'l' links a program, 'q' asks for the outcome.
std::string g_programCalls;
void APIENTRY notedLink(GLuint program) {
  g_programCalls += 'l';
  glFunction<PFNGLLINKPROGRAMPROC>("glLinkProgram")(program);
}
void APIENTRY notedQuery(GLuint program, GLenum name, GLint* value) {
  if (name == GL_LINK_STATUS) g_programCalls += 'q';
  glFunction<PFNGLGETPROGRAMIVPROC>("glGetProgramiv")(program, name, value);
}
// As GL says it: once.
GLenum g_resetStatus = GL_NO_ERROR;
GLenum APIENTRY fakeResetStatus() { return std::exchange(g_resetStatus, GLenum{GL_NO_ERROR}); }
void* fakeAddress(const char* name) {
  if (std::strcmp(name, "glGetGraphicsResetStatus") == 0)
    return reinterpret_cast<void*>(&fakeResetStatus);
  if (g_missingFunction == name) return nullptr;
  if (std::strcmp(name, "glLinkProgram") == 0) return reinterpret_cast<void*>(&notedLink);
  if (std::strcmp(name, "glGetProgramiv") == 0) return reinterpret_cast<void*>(&notedQuery);
  if (std::strcmp(name, "glGetString") == 0) return reinterpret_cast<void*>(&fakeGetString);
  if (std::strcmp(name, "glGetIntegerv") == 0) return reinterpret_cast<void*>(&fakeGetIntegerv);
  return eglAddress(name);
}

class GlLackingTest : public GlRuntimeTest {
 protected:
  void SetUp() override {
    g_fakeVersion.clear();
    g_fakeIntegers.clear();
    g_missingFunction.clear();
    g_programCalls.clear();
    g_resetStatus = GL_NO_ERROR;
    address_ = fakeAddress;
    GlRuntimeTest::SetUp();
  }
  static void expectRefusal(std::initializer_list<std::string_view> words) {
    gl::RuntimeDef def;
    def.getProcAddress = fakeAddress;
    expectError(gl::Runtime::create(std::move(def)), ErrorCode::kUnsupported, words);
  }
};
INSTANTIATE_TEST_SUITE_P(All, GlLackingTest, Values(Api::kGl, Api::kGles), apiTestName);

TEST_P(GlLackingTest, BeginsAllProgramsOfAListBeforeItWaitsForOne) {
  gl::Runtime runtime = makeRuntime();
  const BufferId corners =
      table_.add("corners", kEverything, BufferUsage::kStorage | BufferUsage::kUpload);
  PassList list = smallList(runtime);
  addAccumulate(list, buffer_, other_, 64, 1, 1, true);
  addAccumulate(list, buffer_, other_, 64, 1, 1);
  addFill(list, {}, corners, 3);
  ASSERT_TRUE(runtime.prepare(list));
  EXPECT_EQ(g_programCalls, "lllqqq");
  EXPECT_EQ(runtime.statistics().programsCompiled, 3u);
  const std::vector<PipelineTime> times = runtime.pipelineTimes();
  ASSERT_EQ(times.size(), 3u);
  EXPECT_EQ(times[2].name, "fill_vertex + fill_pixel");
  for (const PipelineTime& time : times) EXPECT_GT(time.milliseconds, 0);
  ASSERT_TRUE(runtime.prepare(list));
  EXPECT_EQ(g_programCalls, "lllqqq");
}

TEST_P(GlLackingTest, KeepsTheOtherProgramsOfAListWithABrokenKernel) {
  gl::Runtime runtime = makeRuntime();
  TestKernel broken("broken", Stage::kCompute,
                    "layout(local_size_x = 64) in;\nvoid main() { x; }\n",
                    {storage("g_target", Access::kWrite, 0)});
  broken.addTo(runtime);
  const PassList good = smallList(runtime);
  PassList list = listOf(broken, 64, buffer_, 256);
  addAccumulate(list, buffer_, other_, 64, 1, 1);
  for (int round = 0; round < 2; ++round) expectError(runtime.prepare(list), "broken");
  const auto links = [] { return std::ranges::count(g_programCalls, 'l'); };
  const auto before = links();
  ASSERT_TRUE(runtime.prepare(good));
  EXPECT_EQ(links(), before);
  EXPECT_EQ(runtime.statistics().programsCompiled, 1u);
}

TEST_P(GlLackingTest, SaysThatTheContextIsLostAndKeepsSayingSo) {
  for (const auto& [status, name] :
       {std::pair(GLenum{GL_GUILTY_CONTEXT_RESET}, "GL_GUILTY_CONTEXT_RESET"),
        std::pair(GLenum{GL_INNOCENT_CONTEXT_RESET}, "GL_INNOCENT_CONTEXT_RESET"),
        std::pair(GLenum{GL_UNKNOWN_CONTEXT_RESET}, "GL_UNKNOWN_CONTEXT_RESET")}) {
    gl::Runtime runtime = makeRuntime();
    const PassList list = smallList(runtime);
    const auto expectLost = [&](const auto& result, const char* call) {
      expectError(result, ErrorCode::kDeviceLost, {call, name, "Scene::recover()"});
    };
    g_resetStatus = status;
    expectLost(runtime.record(list), "record()");
    expectLost(runtime.recordDraws(list, {0, 0, 8, 8}), "recordDraws()");
    expectLost(runtime.update(table_), "update()");
    expectLost(runtime.read(buffer_), "read()");
  }
}

TEST_P(GlLackingTest, NamesTheVersionThatIsTooOld) {
  const bool es = GetParam() == Api::kGles;
  g_fakeVersion = es ? "OpenGL ES 3.1 Toaster 1.0" : "4.4 (Core Profile) Toaster 1.0";
  expectRefusal({g_fakeVersion, es ? "ES 3.2" : "4.5"});
}

TEST_P(GlLackingTest, NamesTheFunctionThatIsMissing) {
  g_missingFunction = "glDispatchCompute";
  expectRefusal({"glDispatchCompute"});
}

TEST_P(GlLackingTest, NamesTheLimitThatIsTooLow) {
  g_fakeIntegers[GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS] = 0;
  expectRefusal({"GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS = 0"});
  g_fakeIntegers = {{GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, 512}};
  expectRefusal({"GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT = 512"});
}

TEST_P(GlLackingTest, RefusesADrawWhoseVertexStageHasNoStorageBuffers) {
  g_fakeIntegers[GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS] = 0;
  gl::Runtime runtime = makeRuntime();  // compute alone still works
  const BufferId corners =
      table_.add("corners", kEverything, BufferUsage::kStorage | BufferUsage::kUpload);
  ASSERT_TRUE(runtime.update(table_));
  PassList list;
  addFill(list, {}, corners, 3);
  expectError(runtime.prepare(list), ErrorCode::kUnsupported,
              {"fill_vertex", "g_corners", "GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS"});
}

TEST(GlRuntime, SaysThatNoContextIsCurrent) {
  gl::RuntimeDef def;
  EXPECT_FALSE(gl::Runtime::create(def));
  def.getProcAddress = [](const char*) -> void* { return nullptr; };
  expectError(gl::Runtime::create(def), "glGetString");
}

TEST_P(GlRuntimeTest, UsesABufferOfTheEngine) {
  gl::Runtime runtime = makeRuntime();
  const std::vector<uint32_t> source = ramp(5, 64);
  const BufferId sourceBuffer =
      table_.add("source", source, BufferUsage::kStorage | BufferUsage::kUpload);
  const BufferId shared = addZeros(table_, "shared", 64);

  const auto bindBuffer = glFunction<PFNGLBINDBUFFERPROC>("glBindBuffer");
  GLuint own = 0;
  glFunction<PFNGLGENBUFFERSPROC>("glGenBuffers")(1, &own);
  EXPECT_FALSE(runtime.registerBuffer(shared, own + 1000));
  bindBuffer(GL_COPY_WRITE_BUFFER, own);
  const auto bufferData = glFunction<PFNGLBUFFERDATAPROC>("glBufferData");
  bufferData(GL_COPY_WRITE_BUFFER, 128, nullptr, GL_DYNAMIC_COPY);
  ASSERT_TRUE(runtime.registerBuffer(shared, own));
  expectError(runtime.update(table_), "shared");

  const std::vector<uint32_t> start = ramp(6, 64);
  bindBuffer(GL_COPY_WRITE_BUFFER, own);
  bufferData(GL_COPY_WRITE_BUFFER, 256, start.data(), GL_DYNAMIC_COPY);
  ASSERT_TRUE(runtime.registerBuffer(shared, own));
  expectOk(runtime.update(table_));
  EXPECT_EQ(runtime.bufferName(shared), own);
  EXPECT_EQ(runtime.statistics().bufferBytes, 256u);  // only the source is the runtime's

  PassList list;
  addAccumulate(list, sourceBuffer, shared, 64, 2, 1);
  record(runtime, list);
  std::vector<uint32_t> expected = start;
  accumulateOnHost(source, expected, 2, 1);
  const auto bytes = required(runtime.read(shared));
  EXPECT_EQ(valuesOf<uint32_t>(*bytes), expected);

  table_.remove(shared);
  ASSERT_TRUE(runtime.update(table_));
  EXPECT_EQ(runtime.bufferName(shared), 0u);
  EXPECT_TRUE(glFunction<PFNGLISBUFFERPROC>("glIsBuffer")(own));  // still the engine's
}

TEST_P(GlRuntimeTest, ReportsInDebugModeWhatTheDriverRefused) {
  gl::Runtime runtime = makeRuntime();
  const BufferId shared = addZeros(table_, "shared", 64);
  GLuint own = 0;
  glFunction<PFNGLGENBUFFERSPROC>("glGenBuffers")(1, &own);
  glFunction<PFNGLBINDBUFFERPROC>("glBindBuffer")(GL_COPY_READ_BUFFER, own);
  glFunction<PFNGLBUFFERDATAPROC>("glBufferData")(GL_COPY_READ_BUFFER, 256, nullptr,
                                                  GL_DYNAMIC_COPY);
  ASSERT_TRUE(runtime.registerBuffer(shared, own));
  ASSERT_TRUE(runtime.update(table_));
  // The engine has forgotten that it has the buffer mapped.
  ASSERT_NE(glFunction<PFNGLMAPBUFFERRANGEPROC>("glMapBufferRange")(GL_COPY_READ_BUFFER, 0, 256,
                                                                    GL_MAP_READ_BIT),
            nullptr);
  PassList list;
  const std::vector<uint32_t> data = ramp(1, 64);
  addUpload(list, shared, std::as_bytes(std::span(data)));
  HazardTracker().resolve(list);
  expectError(runtime.record(list), ErrorCode::kDevice, "GL_INVALID_OPERATION");
}

TEST_P(GlRuntimeTest, MakesAProgramOnceForEachSetOfSpecValues) {
  gl::Runtime runtime = makeRuntime();
  TestKernel kernel("specialised", Stage::kCompute, kSpecialised,
                    {storage("g_target", Access::kWrite, 0)}, {{"kUint", 0, 2}});
  kernel.addTo(runtime);
  const BufferId target = addZeros(table_, "target", 4);
  ASSERT_TRUE(runtime.update(table_));
  for (int round = 0; round < 2; ++round) {
    for (const uint32_t value : {4u, 5u}) {
      PassList list = listOf(kernel, 1, target, 16, {{0, value}, {77, value}});
      record(runtime, list);
    }
  }
  EXPECT_EQ(runtime.statistics().programsCompiled, 2u);
}

TEST_P(GlRuntimeTest, LoadsProgramsFromTheCacheAndCompilesWhatIsCorrupt) {
  if (!makeRuntime().limits().programBinaries) GTEST_SKIP() << "the driver has no program binaries";
  const TestFolder folder;
  const std::filesystem::path directory = folder / "programs";
  const auto files = [&] {
    const std::filesystem::directory_iterator all(directory);
    return std::vector<std::filesystem::path>(begin(all), end(all));
  };
  // Runs the kernel with a new runtime, checks the numbers, and says where its program came from.
  const auto fromDirectory = [&](bool doubled = false) {
    gl::Runtime runtime = makeRuntime(gl::directoryProgramCache(directory.string()));
    ResourceTable table;
    std::vector<uint32_t> source = ramp(5, 64), target = ramp(6, 64);
    const BufferId sourceBuffer =
        table.add("source", source, BufferUsage::kStorage | BufferUsage::kUpload);
    const BufferId targetBuffer =
        table.add("target", target, BufferUsage::kStorage | BufferUsage::kUpload);
    EXPECT_TRUE(runtime.update(table));
    PassList list;
    addAccumulate(list, sourceBuffer, targetBuffer, 64, 2, 1, doubled);
    record(runtime, list);
    accumulateOnHost(source, target, 2, 1, doubled);
    const auto bytes = runtime.read(targetBuffer);
    EXPECT_TRUE(bytes);
    EXPECT_EQ(valuesOf<uint32_t>(bytes ? *bytes : std::vector<std::byte>{}), target);
    return std::pair{runtime.statistics().programsCompiled, runtime.statistics().programsLoaded};
  };
  const std::pair compiled{1u, 0u}, loaded{0u, 1u};

  EXPECT_EQ(fromDirectory(), compiled);
  ASSERT_EQ(files().size(), 1u);
  EXPECT_EQ(fromDirectory(), loaded);

  const std::filesystem::path file = files()[0];
  const auto size = std::filesystem::file_size(file);
  {  // one bit in the middle
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(size / 2));
    const int byte = stream.get();
    stream.seekp(static_cast<std::streamoff>(size / 2));
    stream.put(static_cast<char>(byte ^ 1));
  }
  EXPECT_EQ(fromDirectory(), compiled);
  EXPECT_EQ(fromDirectory(), loaded);  // and the good one is back
  std::filesystem::resize_file(file, size / 3);
  EXPECT_EQ(fromDirectory(), compiled);
  std::filesystem::resize_file(file, 0);
  EXPECT_EQ(fromDirectory(), compiled);
  EXPECT_EQ(fromDirectory(), loaded);

  // Another kernel, another entry.
  EXPECT_EQ(fromDirectory(true), compiled);
  EXPECT_EQ(files().size(), 2u);
}

TEST_P(GlRuntimeTest, CompilesWhatTheDriverRefusesToLoad) {
  if (!makeRuntime().limits().programBinaries) GTEST_SKIP() << "the driver has no program binaries";
  PassList list = smallList();

  // The runtime's own header, intact, in front of bytes that no driver takes: as after an update
  // of the driver that left its version strings as they were.
  std::map<uint64_t, std::vector<std::byte>> stored;
  gl::ProgramCache cache;
  cache.store = [&stored](uint64_t key, std::span<const std::byte> bytes) {
    stored[key].assign(bytes.begin(), bytes.end());
  };
  cache.load = [&stored](uint64_t key) { return stored[key]; };
  {
    gl::Runtime runtime = makeRuntime(cache);
    ASSERT_TRUE(runtime.update(table_));
    record(runtime, list);
  }
  ASSERT_EQ(stored.size(), 1u);
  std::vector<std::byte>& bytes = stored.begin()->second;
  constexpr size_t kHeader = 32, kPayloadHash = 16;
  ASSERT_GT(bytes.size(), kHeader);
  std::fill(bytes.begin() + kHeader, bytes.end(), std::byte{0x5a});
  uint64_t hash = 0xcbf29ce484222325ull;
  for (size_t i = kHeader; i < bytes.size(); ++i)
    hash = (hash ^ static_cast<uint64_t>(bytes[i])) * 0x100000001b3ull;
  std::memcpy(bytes.data() + kPayloadHash, &hash, sizeof(hash));

  gl::Runtime runtime = makeRuntime(cache);
  ASSERT_TRUE(runtime.update(table_));
  record(runtime, list);
  EXPECT_EQ(runtime.statistics().programsCompiled, 1u);
  EXPECT_EQ(runtime.statistics().programsLoaded, 0u);
}

TEST_P(GlRuntimeTest, ReportsHowTheDriverLaysBlocksOut) {
  gl::Runtime runtime = makeRuntime();
  TestKernel kernel("blocks", Stage::kCompute, R"(
struct Root { vec4 rotation; vec4 position; uint bone; uint pad0; uint pad1; uint pad2; };
layout(local_size_x = 64) in;
layout(std140, binding = 2) uniform Constants {
  vec4 gravity;
  uint count;
  float step;
  float table[3];
};
layout(std430, binding = 5) buffer Roots { Root roots[]; };
layout(std430, binding = 1) readonly buffer Lengths { float lengths[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  roots[i].position += gravity * step * lengths[i] * table[int(roots[i].bone)];
  roots[i].rotation = vec4(0.0);
}
)",
                    {});
  kernel.addTo(runtime);
  const Result<std::vector<gl::DriverBlock>> reflected =
      required(runtime.reflectProgram(kernel.variant));
  ASSERT_EQ(reflected->size(), 3u);
  const auto member = [](const gl::DriverBlock& block, const char* name) {
    for (const gl::DriverMember& m : block.members)
      if (m.name.find(name) != std::string::npos) return m;
    ADD_FAILURE() << "no member " << name;
    return gl::DriverMember{};
  };
  const gl::DriverBlock& constants = (*reflected)[0];
  EXPECT_EQ(constants.kind, ResourceKind::kUniformBuffer);
  EXPECT_EQ(constants.binding, 2u);
  EXPECT_EQ(constants.dataSize, 80u);  // 16 + 4 + 4, then 3 elements of 16 at 32
  EXPECT_EQ(member(constants, "gravity").offset, 0u);
  EXPECT_EQ(member(constants, "gravity").type, GLenum{GL_FLOAT_VEC4});
  EXPECT_EQ(member(constants, "count").offset, 16u);
  EXPECT_EQ(member(constants, "step").offset, 20u);
  EXPECT_EQ(member(constants, "table").offset, 32u);
  EXPECT_EQ(member(constants, "table").arraySize, 3u);
  EXPECT_EQ(member(constants, "table").arrayStride, 16u);
  const gl::DriverBlock& lengths = (*reflected)[1];
  EXPECT_EQ(lengths.kind, ResourceKind::kStorageBuffer);
  EXPECT_EQ(lengths.binding, 1u);
  EXPECT_EQ(member(lengths, "lengths").arrayStride, 4u);
  const gl::DriverBlock& roots = (*reflected)[2];
  EXPECT_EQ(roots.binding, 5u);
  EXPECT_EQ(member(roots, "rotation").offset, 0u);
  EXPECT_EQ(member(roots, "position").offset, 16u);
  EXPECT_EQ(member(roots, "bone").offset, 32u);
  EXPECT_EQ(member(roots, "bone").topLevelArrayStride, 48u);
  EXPECT_EQ(member(roots, "bone").topLevelArraySize, 0u);
}

TEST_P(GlRuntimeTest, KeepsSeveralTimersInFlight) {
  gl::Runtime runtime = makeRuntime();
  PassList list = smallList(runtime);
  addAccumulate(list, other_, buffer_, 64, 1, 1);
  std::vector<gl::PassTimer> timers;
  timers.reserve(3);
  for (int i = 0; i < 3; ++i) timers.emplace_back(runtime);
  for (int frame = 0; frame < 9; ++frame) {
    gl::PassTimer& timer = timers[static_cast<size_t>(frame % 3)];
    EXPECT_EQ(timer.read().size(), frame < 3 ? 0u : 2u);
    EXPECT_TRUE(timer.ready());
    record(runtime, list, &timer);
  }
}

constexpr GLenum kCapabilities[] = {GL_SCISSOR_TEST,        GL_DEPTH_TEST,
                                    GL_CULL_FACE,           GL_STENCIL_TEST,
                                    GL_POLYGON_OFFSET_FILL, GL_RASTERIZER_DISCARD,
                                    GL_SAMPLE_COVERAGE,     GL_SAMPLE_ALPHA_TO_COVERAGE,
                                    GL_SAMPLE_MASK,         GL_PRIMITIVE_RESTART_FIXED_INDEX};

// Every piece of state that the guard promises, by its query.
std::vector<int64_t> snapshot(Api api) {
  const auto getInteger = glFunction<PFNGLGETINTEGERVPROC>("glGetIntegerv");
  const auto getIndexed = glFunction<PFNGLGETINTEGER64I_VPROC>("glGetInteger64i_v");
  const auto getIndexed32 = glFunction<PFNGLGETINTEGERI_VPROC>("glGetIntegeri_v");
  const auto getBooleans = glFunction<PFNGLGETBOOLEANI_VPROC>("glGetBooleani_v");
  const auto isEnabled = glFunction<PFNGLISENABLEDPROC>("glIsEnabled");
  const auto isEnabledIndexed = glFunction<PFNGLISENABLEDIPROC>("glIsEnabledi");
  const auto getFloat = glFunction<PFNGLGETFLOATVPROC>("glGetFloatv");
  std::vector<int64_t> state;
  for (const GLenum name : {GL_CURRENT_PROGRAM, GL_VERTEX_ARRAY_BINDING, GL_UNIFORM_BUFFER_BINDING,
                            GL_SHADER_STORAGE_BUFFER_BINDING, GL_COPY_READ_BUFFER_BINDING,
                            GL_COPY_WRITE_BUFFER_BINDING, GL_DISPATCH_INDIRECT_BUFFER_BINDING,
                            GL_DRAW_INDIRECT_BUFFER_BINDING, GL_DEPTH_FUNC, GL_DEPTH_WRITEMASK}) {
    GLint value = 0;
    getInteger(static_cast<GLenum>(name), &value);
    state.push_back(value);
  }
  for (GLuint i = 0; i < gl::kMaxBindings; ++i) {
    for (const GLenum name : {GL_UNIFORM_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_BINDING}) {
      GLint value = 0;
      getIndexed32(name, i, &value);
      state.push_back(value);
    }
    for (const GLenum name : {GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE,
                              GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE}) {
      GLint64 value = 0;
      getIndexed(name, i, &value);
      state.push_back(value);
    }
  }
  GLfloat range[2] = {};
  getFloat(GL_DEPTH_RANGE, range);
  for (const GLfloat value : range) state.push_back(std::bit_cast<int32_t>(value));
  GLfloat viewport[4] = {};
  getFloat(GL_VIEWPORT, viewport);
  for (const GLfloat value : viewport) state.push_back(std::bit_cast<int32_t>(value));
  for (const GLenum name : kCapabilities) state.push_back(isEnabled(name));
  for (GLuint i = 0; i < 4; ++i) {
    state.push_back(isEnabledIndexed(GL_BLEND, i));
    GLboolean mask[4] = {};
    getBooleans(GL_COLOR_WRITEMASK, i, mask);
    for (const GLboolean value : mask) state.push_back(value);
    for (const GLenum name : {GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA, GL_BLEND_SRC_RGB,
                              GL_BLEND_SRC_ALPHA, GL_BLEND_DST_RGB, GL_BLEND_DST_ALPHA}) {
      GLint value = 0;
      getIndexed32(name, i, &value);
      state.push_back(value);
    }
  }
  if (api == Api::kGl) {
    for (const GLenum name : {GL_CLIP_ORIGIN, GL_CLIP_DEPTH_MODE, GL_POLYGON_MODE}) {
      GLint value[2] = {};
      getInteger(name, value);
      state.push_back(value[0]);
    }
    state.push_back(isEnabled(GL_PRIMITIVE_RESTART));
  }
  return state;
}

TEST_P(GlRuntimeTest, GuardsTheStateOfTheEngine) {
  gl::Runtime runtime = makeRuntime();
  const BufferUsage upload = BufferUsage::kStorage | BufferUsage::kUpload;
  const BufferId buffer = addZeros(table_, "buffer", 64, upload);
  const BufferId other =
      addZeros(table_, "other", 64, BufferUsage::kStorage | BufferUsage::kIndirect);
  const BufferId zeros = addZeros(table_, "zeros", 4, BufferUsage::kIndirect);
  const BufferId corners =
      table_.add("corners", kEverything, BufferUsage::kStorage | BufferUsage::kUpload);
  ASSERT_TRUE(runtime.update(table_));
  PassList list;
  const std::vector<uint32_t> groups(64, 1);
  addUpload(list, other, std::as_bytes(std::span(groups)));
  addAccumulate(list, buffer, other, 64, 1, 0);
  addAccumulate(list, other, buffer, 64, 1, 0);
  list.passes.back().kind = PassKind::kDispatchIndirect;
  list.passes.back().indirect = other;
  addFill(list, {.depthCompare = DepthCompare::kGreater, .depthWrite = false}, corners, 3);
  list.passes.back().kind = PassKind::kDrawIndirect;
  list.passes.back().indirect = zeros;  // draws nothing
  HazardTracker().resolve(list);

  // An 8 x 8 target of the engine's.
  GLuint renderbuffer = 0, framebuffer = 0;
  glFunction<PFNGLGENRENDERBUFFERSPROC>("glGenRenderbuffers")(1, &renderbuffer);
  glFunction<PFNGLBINDRENDERBUFFERPROC>("glBindRenderbuffer")(GL_RENDERBUFFER, renderbuffer);
  glFunction<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage")(GL_RENDERBUFFER, GL_RGBA8, 8,
                                                                    8);
  glFunction<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers")(1, &framebuffer);
  glFunction<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer")(GL_FRAMEBUFFER, framebuffer);
  glFunction<PFNGLFRAMEBUFFERRENDERBUFFERPROC>("glFramebufferRenderbuffer")(
      GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, renderbuffer);

  // Everything unlike GL's defaults and unlike what pelage sets.
  GLuint buffers[3] = {};
  glFunction<PFNGLGENBUFFERSPROC>("glGenBuffers")(3, buffers);
  const auto bindBuffer = glFunction<PFNGLBINDBUFFERPROC>("glBindBuffer");
  for (const GLuint name : buffers) {
    bindBuffer(GL_COPY_WRITE_BUFFER, name);
    glFunction<PFNGLBUFFERDATAPROC>("glBufferData")(GL_COPY_WRITE_BUFFER, 4096, nullptr,
                                                    GL_STATIC_DRAW);
  }
  GLuint vertexArray = 0;
  glFunction<PFNGLGENVERTEXARRAYSPROC>("glGenVertexArrays")(1, &vertexArray);
  glFunction<PFNGLBINDVERTEXARRAYPROC>("glBindVertexArray")(vertexArray);
  for (GLuint i = 0; i < 3; ++i) {
    const auto bindBase = glFunction<PFNGLBINDBUFFERBASEPROC>("glBindBufferBase");
    const auto bindRange = glFunction<PFNGLBINDBUFFERRANGEPROC>("glBindBufferRange");
    bindBase(GL_UNIFORM_BUFFER, 2 * i, buffers[i]);
    bindRange(GL_UNIFORM_BUFFER, 2 * i + 1, buffers[i], GLintptr{256} * i, 512);
    bindRange(GL_SHADER_STORAGE_BUFFER, 2 * i, buffers[i], GLintptr{256} * i, 256);
    bindBase(GL_SHADER_STORAGE_BUFFER, 2 * i + 1, buffers[i]);
  }
  bindBuffer(GL_UNIFORM_BUFFER, buffers[1]);
  bindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[2]);
  bindBuffer(GL_COPY_READ_BUFFER, buffers[0]);
  bindBuffer(GL_COPY_WRITE_BUFFER, buffers[1]);
  bindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffers[2]);
  bindBuffer(GL_DRAW_INDIRECT_BUFFER, buffers[0]);
  const auto enable = glFunction<PFNGLENABLEPROC>("glEnable");
  for (const GLenum name : kCapabilities) enable(name);
  glFunction<PFNGLVIEWPORTPROC>("glViewport")(1, 2, 3, 4);
  glFunction<PFNGLDEPTHRANGEFPROC>("glDepthRangef")(0.25f, 0.75f);
  glFunction<PFNGLDEPTHFUNCPROC>("glDepthFunc")(GL_NOTEQUAL);
  glFunction<PFNGLDEPTHMASKPROC>("glDepthMask")(GL_TRUE);
  glFunction<PFNGLENABLEIPROC>("glEnablei")(GL_BLEND, 2);
  glFunction<PFNGLCOLORMASKIPROC>("glColorMaski")(1, GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
  glFunction<PFNGLBLENDEQUATIONSEPARATEIPROC>("glBlendEquationSeparatei")(1, GL_FUNC_SUBTRACT,
                                                                          GL_FUNC_REVERSE_SUBTRACT);
  glFunction<PFNGLBLENDFUNCSEPARATEIPROC>("glBlendFuncSeparatei")(0, GL_DST_COLOR, GL_ZERO,
                                                                  GL_DST_ALPHA, GL_ONE);
  if (GetParam() == Api::kGl) {
    glFunction<PFNGLCLIPCONTROLPROC>("glClipControl")(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    glFunction<PFNGLPOLYGONMODEPROC>("glPolygonMode")(GL_FRONT_AND_BACK, GL_LINE);
    enable(GL_PRIMITIVE_RESTART);
  }
  ASSERT_EQ(glGetError_(), GLenum{GL_NO_ERROR});

  const std::vector<int64_t> before = snapshot(GetParam());
  {
    const gl::StateGuard guard(runtime);
    record(runtime, list);
    expectOk(runtime.recordDraws(list, {0, 0, 8, 8}));
    ASSERT_TRUE(runtime.read(buffer));
    EXPECT_NE(snapshot(GetParam()), before);  // otherwise this test would show nothing
  }
  EXPECT_EQ(snapshot(GetParam()), before);
}

TEST_P(GlRuntimeTest, KnowsTexturesUntilTheyAreForgotten) {
  gl::Runtime runtime = makeRuntime();
  const TextureId texture = newTextureId();
  const auto saysUnknown = [&] {
    PassList list = listWithTexture(texture);
    const Result<void> recorded = runtime.record(list);
    if (recorded) return false;
    return recorded.error().message.find("'g_picture': the runtime does not know the texture") !=
           std::string::npos;
  };
  EXPECT_TRUE(saysUnknown());
  runtime.registerTexture(texture, {.target = GL_TEXTURE_2D_ARRAY, .name = 1});
  EXPECT_FALSE(saysUnknown());
  runtime.registerTexture(newTextureId(), {});
  EXPECT_FALSE(saysUnknown());
  runtime.registerTexture(texture, {.target = GL_TEXTURE_2D_ARRAY});
  EXPECT_TRUE(saysUnknown());
}

// Lists with textures change the units' textures of registered targets; the guard restores them.
TEST_P(GlRuntimeTest, GuardsTexturesAndSamplersOfTheEngine) {
  gl::Runtime runtime = makeRuntime();
  const auto activate = glFunction<PFNGLACTIVETEXTUREPROC>("glActiveTexture");
  const auto bindTexture = glFunction<PFNGLBINDTEXTUREPROC>("glBindTexture");
  const auto bindSampler = glFunction<PFNGLBINDSAMPLERPROC>("glBindSampler");
  const auto getInteger = glFunction<PFNGLGETINTEGERVPROC>("glGetIntegerv");
  GLuint textures[3] = {}, sampler = 0;
  glFunction<PFNGLGENTEXTURESPROC>("glGenTextures")(3, textures);
  glFunction<PFNGLGENSAMPLERSPROC>("glGenSamplers")(1, &sampler);
  const auto state = [&] {
    std::vector<GLint> values;
    GLint active = 0;
    getInteger(GL_ACTIVE_TEXTURE, &active);
    values.push_back(active);
    for (GLuint unit = 0; unit < gl::kMaxTextures; ++unit) {
      activate(GL_TEXTURE0 + unit);
      for (const GLenum name :
           {GL_TEXTURE_BINDING_2D_ARRAY, GL_TEXTURE_BINDING_CUBE_MAP, GL_SAMPLER_BINDING})
        getInteger(name, &values.emplace_back(0));
    }
    activate(static_cast<GLenum>(active));
    return values;
  };
  activate(GL_TEXTURE3);
  bindTexture(GL_TEXTURE_2D_ARRAY, textures[0]);
  bindTexture(GL_TEXTURE_CUBE_MAP, textures[1]);
  bindSampler(0, sampler);
  bindSampler(3, sampler);
  const std::vector<GLint> before = state();
  for (const GLenum target : {GL_TEXTURE_2D_ARRAY, GL_TEXTURE_CUBE_MAP})
    runtime.registerTexture(newTextureId(), {.target = target, .name = textures[2]});
  {
    const gl::StateGuard guard(runtime);
    activate(GL_TEXTURE0);
    bindTexture(GL_TEXTURE_2D_ARRAY, textures[2]);
    bindSampler(0, 0);
    activate(GL_TEXTURE3);
    bindTexture(GL_TEXTURE_2D_ARRAY, 0);
    bindTexture(GL_TEXTURE_CUBE_MAP, 0);
    activate(GL_TEXTURE5);
    EXPECT_NE(state(), before);
  }
  EXPECT_EQ(state(), before);
  EXPECT_EQ(glGetError_(), GLenum{GL_NO_ERROR});
}

TEST(GlBarriers, AskForExactlyTheBitsThatGlNeeds) {
  const StageMask compute = stageBit(Stage::kCompute);
  const auto bits = [](Barrier barrier) { return gl::memoryBarrierBits({&barrier, 1}); };
  EXPECT_EQ(gl::memoryBarrierBits({}), 0u);
  // Shader to shader, in every direction.
  EXPECT_EQ(bits({.before = Access::kWrite,
                  .after = Access::kRead,
                  .beforeStages = compute,
                  .afterStages = stageBit(Stage::kVertex)}),
            uint32_t{GL_SHADER_STORAGE_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kRead,
                  .after = Access::kWrite,
                  .beforeStages = compute,
                  .afterStages = compute}),
            uint32_t{GL_SHADER_STORAGE_BARRIER_BIT});
  // GL orders what the host writes before what follows.
  EXPECT_EQ(bits({.before = Access::kWrite,
                  .after = Access::kRead,
                  .afterStages = compute,
                  .beforeUpload = true}),
            0u);
  EXPECT_EQ(bits({.before = Access::kRead,
                  .after = Access::kWrite,
                  .beforeStages = compute,
                  .afterUpload = true}),
            0u);
  // The rest of GL sees a shader's writes after a barrier only.
  EXPECT_EQ(bits({.before = Access::kWrite,
                  .after = Access::kWrite,
                  .beforeStages = compute,
                  .afterUpload = true}),
            uint32_t{GL_BUFFER_UPDATE_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kWrite, .beforeStages = compute, .afterIndirect = true}),
            uint32_t{GL_COMMAND_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kWrite, .beforeStages = compute, .afterIndex = true}),
            uint32_t{GL_ELEMENT_ARRAY_BARRIER_BIT});
  EXPECT_EQ(bits({.before = Access::kWrite, .beforeStages = compute, .afterVertex = true}),
            uint32_t{GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT});
  const Barrier both[] = {{.before = Access::kWrite, .beforeStages = compute, .afterIndex = true},
                          {.before = Access::kWrite,
                           .after = Access::kRead,
                           .beforeStages = compute,
                           .afterStages = stageBit(Stage::kVertex)}};
  EXPECT_EQ(gl::memoryBarrierBits(both),
            uint32_t{GL_ELEMENT_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT});
}

}  // namespace
}  // namespace pelage::test
