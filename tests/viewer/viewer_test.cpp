// The viewer in a window: scripts orbit, pause, resize and quit; the pictures show hair, and are
// the same in every run. The display is an Xvfb that the test starts. A start takes longer than
// many frames of little hair: one session does many things.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "image.h"
#include "pelage/demo/groom.h"
#include "pelage/settings/settings_file.h"
#include "png_file.h"
#include "support/errors.h"
#include "support/full_stress.h"
#include "support/gpu_fixture.h"
#include "support/picture_statistics.h"
#include "support/test_folder.h"
#include "viewer/script_makers.h"
#include "viewer/window_apis.h"
#include "viewer/x_display.h"
#include "window/window.h"

namespace {

using pelage::Api;
using pelage::test::expectHas;
using pelage::test::kFirstApi;
using pelage::test::ProgramOutput;
using pelage::test::statisticsOf;
using sample::ByteImage;
using Path = std::filesystem::path;
using pelage::test::required;
using pelage::test::runIn;
using pelage::test::TestFolder;
using pelage::test::textOf;

// Starts the display with the first test; it lives until the end of the program.
const std::string& display() {
  static const pelage::test::XDisplay kDisplay;
  return kDisplay.name();
}

/// Returns settings with which few strands cover much of the picture.
pelage::SceneSettings wideHair() {
  pelage::SceneSettings settings;
  settings.material.fiberRadius = 0.0015f;
  settings.follow.countPerGuide = 0;
  settings.transparency.method = pelage::Transparency::kShortCut;
  return settings;
}

/// A folder for one session, with hair that is fast to simulate and to draw.
class Folder {
 public:
  Path file(const std::string& name) const { return path_ / name; }

  void writeHair() const {
    pelage::GroomDef def;
    def.strandCount = 300;
    def.verticesPerStrand = 8;
    def.headCellSize = 0.007f;
    const auto groom = required(pelage::generateGroom(def));
    required(pelage::writeGroom(*groom, path_.path(), "hair"));
    required(pelage::saveSettings(file("wide.json"), wideHair()));
  }

  /// Runs a script in a window of 160 x 120. \param api empty: the viewer chooses.
  /// \param environment "NAME=value NAME=value"
  ProgramOutput run(const std::string& api, const std::string& script,
                    const std::string& arguments = "", const std::string& displayName = display(),
                    const std::string& environment = "") const {
    (void)path_.write("script.txt", script);
    return pelage::test::runIn(
        path_.path(), "DISPLAY=" + displayName + " " + environment + " '" + PELAGE_VIEWER + "'" +
                          (api.empty() ? "" : " --api " + api) +
                          " --validation --size 160x120 --cache none --script script.txt " +
                          arguments);
  }

 private:
  pelage::test::TestFolder path_;
};

/// The results of a session: exit status, stderr, pictures by name, recorded input.
struct Session {
  ProgramOutput output;
  std::map<std::string, ByteImage> pictures;
  std::string recorded;

  ByteImage picture(const std::string& name) const {
    const auto found = pictures.find(name);
    EXPECT_TRUE(found != pictures.end()) << "there is no " << name;
    return found != pictures.end() ? found->second : ByteImage{};
  }
};

Session sessionOf(const std::string& api, const Folder& folder, const std::string& script,
                  const std::string& arguments, const std::string& displayName = display()) {
  Session session;
  session.output = folder.run(api, script, arguments + " --coarse 1 --shadow none", displayName);
  for (const auto& entry : std::filesystem::directory_iterator(folder.file(""))) {
    if (entry.path().extension() != ".png") continue;
    const auto image = sample::readPng(entry.path().string());
    EXPECT_TRUE(image) << (image ? "" : image.error().message);
    if (image) session.pictures[entry.path().stem().string()] = *image;
    std::filesystem::remove(entry.path());
  }
  session.recorded = pelage::test::textOf(folder.file("recorded.txt"));
  return session;
}

constexpr const char* kManyThings = R"(
0 key tab
0 screenshot start
1 screenshot moved
2 key space
2 screenshot paused
3 screenshot paused_later
4 move 80 60
4 press left
4 move 110 65
4 release left
4 screenshot orbited
5 move 50 50
5 press right
5 move 45 60
5 release right
5 key f
5 scroll 3
5 text 120
5 key .
5 screenshot near
6 resize 200 100
6 screenshot resized
7 drop broken.tfx
8 screenshot message
9 key escape
11 screenshot behind_message
12 key f
12 key space
12 key r
14 screenshot free
15 key r
17 screenshot free_again
18 key r
18 keydown control
18 move 130 50
18 press left
19 move 110 50
19 release left
19 keyup control
20 key b
20 screenshot pushed
21 key r
21 keydown g
21 move 130 60
21 press left
22 move 160 50
23 screenshot pulled
24 release left
24 keyup g
25 minimize
26 move 70 60
28 restore
29 screenshot restored
)";

// Returns a script that begins some frames later.
std::string shifted(const std::string& script, uint64_t frames) {
  std::istringstream lines(script);
  std::string result, event;
  for (uint64_t frame = 0; lines >> frame && std::getline(lines, event);)
    result += std::to_string(frame + frames) + event + "\n";
  return result;
}

class Viewer : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    if (display().empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: Xvfb does not start";
  }
  static std::string api() { return pelage::apiName(GetParam()); }
  /// Expects hair in columns of a picture. \param first, end the columns; 0, 0: all.
  static void expectHair(const ByteImage& image, const std::string& name, uint32_t first = 0,
                         uint32_t end = 0) {
    const auto s = statisticsOf(image, first, end);
    EXPECT_TRUE(s.drawnShare > 0.1 && s.drawnShare < 0.95) << name << ": " << s.drawnShare;
    EXPECT_TRUE(s.mean > 20 && s.mean < 230) << name << ": " << s.mean;
    EXPECT_TRUE(s.detailShare > 0.1) << name << ": " << s.detailShare;
  }
};

TEST_P(Viewer, ShowsHairAndDoesWhatAScriptSays) {
  const Folder folder;
  folder.writeHair();
  std::ofstream(folder.file("broken.tfx")) << "no hair at all";
  std::string script = kManyThings;
  for (size_t at = script.find("screenshot "); at != std::string::npos;
       at = script.find("screenshot ", at + 1))
    script.insert(script.find('\n', at), ".png");
  const std::string arguments = "hair.tfx --strands 1 --settings wide.json ";
  const Session session = sessionOf(api(), folder, script, arguments + "--record recorded.txt");
  ASSERT_EQ(session.output.code, 0) << session.output.errors;
  EXPECT_EQ(session.output.errors, "");
  const auto expectOther = [&](const char* name, const char* other) {
    EXPECT_NE(session.picture(name).rgb, session.picture(other).rgb) << name << ", " << other;
  };
  const auto expectSame = [&](const char* name, const char* other) {
    EXPECT_EQ(session.picture(name).rgb, session.picture(other).rgb) << name << ", " << other;
  };
  EXPECT_EQ(session.picture("start").width, 160u);
  EXPECT_EQ(session.picture("start").height, 120u);
  for (const char* name : {"start", "orbited", "near", "resized", "free", "restored"})
    expectHair(session.picture(name), name);
  expectOther("start", "moved");
  expectSame("paused", "paused_later");
  expectOther("paused", "orbited");
  expectOther("orbited", "near");
  EXPECT_EQ(session.picture("resized").width, 200u);
  EXPECT_EQ(session.picture("resized").height, 100u);
  // A broken file is a message, and the scene stays.
  expectOther("resized", "message");
  expectSame("resized", "behind_message");
  // A reset begins again, and a ball moves hair.
  expectSame("free", "free_again");
  expectOther("free", "pushed");
  // It goes on behind the task bar.
  expectOther("restored", "pulled");
  expectHas(session.recorded, "25 minimize");

  // The mouse pulls a lock and no other hair.
  const ByteImage free = session.picture("free"), pulled = session.picture("pulled");
  ASSERT_EQ(free.rgb.size(), pulled.rgb.size());
  const uint32_t half = free.width / 2;
  size_t left = 0, right = 0;
  for (size_t i = 0; i < free.rgb.size(); ++i)
    if (free.rgb[i] != pulled.rgb[i]) ++(i / 3 % free.width < half ? left : right);
  EXPECT_EQ(left, 0u);
  EXPECT_GT(right, 30u);

  // The recording is a script of the same session, whatever the API.
  if (GetParam() != kFirstApi) return;
  const Session replay = sessionOf(api(), folder, session.recorded, arguments);
  ASSERT_EQ(replay.output.code, 0) << replay.output.errors;
  ASSERT_EQ(replay.pictures.size(), session.pictures.size());
  for (const auto& [name, picture] : session.pictures)
    EXPECT_EQ(picture.rgb, replay.picture(name).rgb) << name;
}

// The program sleeps while its window is minimized.
TEST(Window, IsHiddenWhileItIsMinimizedAndWaits) {
  if (display().empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: Xvfb does not start";
  setenv("DISPLAY", display().c_str(), 1);
  const auto window = required(viewer::Window::create({.width = 160, .height = 120}));
  EXPECT_FALSE((*window)->size().hidden);
  required((*window)->minimize(true));
  EXPECT_TRUE((*window)->size().hidden);
  std::vector<viewer::Event> events;
  (*window)->poll(events, false);
  const auto before = std::chrono::steady_clock::now();
  for (int i = 0; i < 5; ++i) (*window)->poll(events, true);
  EXPECT_GT(std::chrono::steady_clock::now() - before, std::chrono::milliseconds(200));
  ASSERT_TRUE((*window)->minimize(false));
  EXPECT_FALSE((*window)->size().hidden);
  EXPECT_EQ((*window)->size().width, 160u);
  EXPECT_EQ((*window)->size().interfaceScale, 1.0f);
}

// Returns the mean of the channels of some columns, 0..255.
double meanOfColumns(const ByteImage& image, uint32_t first, uint32_t end) {
  double sum = 0;
  for (size_t i = 0; i < image.rgb.size(); ++i)
    if (i / 3 % image.width >= first && i / 3 % image.width < end) sum += image.rgb[i];
  return sum / (3.0 * (end - first) * image.height);
}

// With twice the usual dots per inch the panel is twice as wide, and its first button, Pause, can
// be clicked where it is drawn.
TEST_P(Viewer, GrowsWithTheDotsOfTheDisplay) {
  if (GetParam() != kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  static const pelage::test::XDisplay kFine(192);
  const Folder folder;
  folder.writeHair();
  const Session session = sessionOf(api(), folder,
                                    "0 resize 600 160\n1 move 74 88\n3 press left\n"
                                    "4 release left\n5 move 590 150\n6 screenshot panel.png\n"
                                    "7 key tab\n8 screenshot paused.png\n9 screenshot later.png\n",
                                    "hair.tfx --strands 1 --settings wide.json", kFine.name());
  ASSERT_EQ(session.output.code, 0) << session.output.errors;
  EXPECT_EQ(session.output.errors, "");
  const ByteImage panel = session.picture("panel"), paused = session.picture("paused");
  EXPECT_LT(meanOfColumns(panel, 300, 480), 0.7 * meanOfColumns(paused, 300, 480));
  EXPECT_EQ(meanOfColumns(panel, 570, 600), meanOfColumns(paused, 570, 600));
  EXPECT_TRUE(paused.rgb == session.picture("later").rgb);
}

// Returns the mean difference of two pictures' channels, 0..255.
double meanDifference(const ByteImage& a, const ByteImage& b) {
  EXPECT_EQ(a.rgb.size(), b.rgb.size());
  double sum = 0;
  for (size_t i = 0; i < std::min(a.rgb.size(), b.rgb.size()); ++i)
    sum += std::abs(a.rgb[i] - b.rgb[i]);
  return sum / static_cast<double>(a.rgb.size());
}

// All methods draw the same hair.
TEST_P(Viewer, DrawsWithEveryMethodAndTakesEverySetting) {
  const Folder folder;
  folder.writeHair();
  std::vector<std::string> methods;
  std::string script =
      "0 key tab\n0 key space\n" + pelage::test::everyMethod(wideHair(), folder.file(""), methods);
  // Settings do not depend on the API.
  if (GetParam() == kFirstApi)
    script += shifted(pelage::test::everySetting(wideHair(), folder.file("")), 30);
  const Session session =
      sessionOf(api(), folder, script, "hair.tfx --strands 1 --settings wide.json");
  ASSERT_EQ(session.output.code, 0) << session.output.errors;
  EXPECT_EQ(session.output.errors, "");
  const ByteImage exact = session.picture("method_windowed");
  expectHair(exact, "windowed");
  for (const std::string& method : methods) {
    const bool samples = method == "stochastic" || method == "alphaTest";
    EXPECT_LT(meanDifference(session.picture("method_" + method), exact), samples ? 6 : 1)
        << method;
  }
  expectHair(session.picture("shadow"), "with shadows");
  const ByteImage view = session.picture("view");
  EXPECT_LT(meanDifference(view, session.picture("method_shortCut")), 2);
  EXPECT_NE(view.rgb, session.picture("method_shortCut").rgb);
}

// Random input causes no errors and no messages of the validation.
TEST_P(Viewer, SurvivesRandomInput) {
  const Folder folder;
  folder.writeHair();
  std::ofstream(folder.file("broken.tfx")) << "no hair at all";
  if (!pelage::test::fullStress()) GTEST_SKIP() << "scripts/test_all.sh viewer runs it";
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  uint32_t seed = 1;
  do {
    std::vector<std::string> files = {"hair.tfx", "broken.tfx", "wide.json"};
    for (uint32_t i = 0; i < 5; ++i)
      files.push_back(
          pelage::test::randomSettingsFile(wideHair(), 100 * seed + i, folder.file("")));
    const ProgramOutput output = folder.run(api(), pelage::test::randomInput(seed, 400, files),
                                            "hair.tfx --settings wide.json");
    EXPECT_EQ(output.code, 0) << "seed " << seed << ": " << output.errors;
    EXPECT_EQ(output.errors, "") << "seed " << seed;
    ++seed;
  } while (std::chrono::steady_clock::now() < end && !HasFailure());
}

// A changed kernel of a folder replaces the program's own. A mistake in it is a message with file
// and line, and the program's own kernel stays.
TEST_P(Viewer, CompilesKernelsOfAFolder) {
  const Folder folder;
  folder.writeHair();
  std::filesystem::copy(Path(PELAGE_SOURCE_DIR) / "kernels", folder.file("kernels"),
                        std::filesystem::copy_options::recursive);
  const Path kernel = folder.file("kernels") / "shading" / "strand_pixel.hlsl";
  pelage::SceneSettings settings = wideHair();
  settings.transparency.method = pelage::Transparency::kAlphaTest;
  ASSERT_TRUE(pelage::saveSettings(folder.file("alpha.json"), settings));
  const std::string source = pelage::test::textOf(kernel);
  const std::string line = "lightStrand(renderShading(), surface)";
  ASSERT_NE(source.find(line), std::string::npos);
  const auto pictureWith = [&](const std::string& text, const char* script) {
    std::ofstream(kernel) << std::string(source).replace(source.find(line), line.size(), text);
    const Session session = sessionOf(
        api(), folder, script, "hair.tfx --strands 1 --settings alpha.json --kernels kernels");
    EXPECT_EQ(session.output.code, 0) << session.output.errors;
    return session.picture("picture");
  };
  const auto greenShare = [](const ByteImage& image) {
    size_t green = 0;
    for (size_t i = 0; i + 2 < image.rgb.size(); i += 3)
      green += image.rgb[i + 1] > 150 && image.rgb[i] < 30 && image.rgb[i + 2] < 30 ? 1 : 0;
    return static_cast<double>(green) / static_cast<double>(image.rgb.size() / 3);
  };
  const char* const script = "0 key tab\n0 key space\n1 screenshot picture.png\n";
  const ByteImage green = pictureWith("float3(0.0, 40.0, 0.0) * " + line, script);
  EXPECT_GT(greenShare(green), 0.1);
  // The message does not depend on the API.
  if (GetParam() != kFirstApi) return;
  const ByteImage broken =
      pictureWith("nothing(", "0 key tab\n0 key space\n1 key enter\n3 screenshot picture.png\n");
  EXPECT_EQ(greenShare(broken), 0);
  EXPECT_GT(statisticsOf(broken).drawnShare, 0.05);
}

// Without arguments the viewer shows the character, even after a loss of the device.
TEST_P(Viewer, ShowsTheCharacterAndALostDeviceComesBack) {
  const Folder folder;
  const Session session = sessionOf(
      api(), folder,
      "0 key tab\n0 screenshot start.png\n1 key f9\n2 key enter\n4 screenshot later.png\n",
      "--strands 0.2");
  ASSERT_EQ(session.output.code, 0) << session.output.errors;
  EXPECT_EQ(session.output.errors, "");
  expectHair(session.picture("start"), "at the start");
  expectHair(session.picture("later"), "behind the loss");
}

// Each view differs from the previous one; after the last one, the hair looks as before. Then the
// dialog opens a file by its name.
TEST_P(Viewer, LooksInsideAndOpensFiles) {
  if (GetParam() != kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  const Folder folder;
  std::ofstream(folder.file("broken.tfx")) << "no hair at all";
  std::string script = "0 key tab\n1 key space\n1 screenshot 0.png\n";
  for (int view = 1; view <= 9; ++view)
    script += std::to_string(2 * view) + " key v\n" + std::to_string(2 * view + 1) +
              " screenshot " + std::to_string(view) + ".png\n";
  script += "20 key c\n20 screenshot contacts.png\n21 key c\n21 key o\n24 screenshot dialog.png\n";
  for (const char letter : std::string("broken.tfx"))
    script += "24 text " + std::to_string(static_cast<int>(letter)) + "\n";
  script += "26 key enter\n29 screenshot message.png\n30 key escape\n32 screenshot after.png\n";
  const Session session =
      sessionOf(api(), folder, script, "--groom straight --head-collider mesh --strands 0.05");
  ASSERT_EQ(session.output.code, 0) << session.output.errors;
  EXPECT_EQ(session.output.errors, "");
  const ByteImage hair = session.picture("0");
  expectHair(hair, "hair");
  for (int view = 1; view <= 9; ++view)
    EXPECT_NE(session.picture(std::to_string(view)).rgb,
              session.picture(std::to_string(view - 1)).rgb)
        << view;
  EXPECT_EQ(session.picture("9").rgb, hair.rgb);
  EXPECT_NE(session.picture("contacts").rgb, hair.rgb);
  EXPECT_NE(session.picture("dialog").rgb, hair.rgb);
  EXPECT_NE(session.picture("message").rgb, session.picture("dialog").rgb);
  EXPECT_EQ(session.picture("after").rgb, hair.rgb);
}

// Two solvers are shown side by side, with settings of one side and hair that is pulled in the
// other; then one side again.
TEST_P(Viewer, ShowsTwoSidesAndOneAgain) {
  const Folder folder;
  const Session session = sessionOf(
      api(), folder,
      "0 key i\n0 key e\n1 screenshot panels.png\n2 key tab\n3 screenshot two.png\n"
      "4 keydown g\n4 move 110 60\n4 press left\n5 move 130 50\n6 release left\n6 keyup g\n"
      "7 resize 240 120\n7 screenshot resized.png\n8 key d\n8 screenshot one.png\n",
      "--groom straight --compare classic --strands 0.2");
  ASSERT_EQ(session.output.code, 0) << session.output.errors;
  EXPECT_EQ(session.output.errors, "");
  EXPECT_NE(session.picture("panels").rgb, session.picture("two").rgb);
  for (const char* name : {"two", "resized"}) {
    const ByteImage two = session.picture(name);
    expectHair(two, "left", 0, two.width / 2);
    expectHair(two, "right", two.width / 2, two.width);
  }
  expectHair(session.picture("one"), "one");
}

TEST_P(Viewer, WithoutADisplayItSaysSo) {
  if (GetParam() != kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  const Folder folder;
  const ProgramOutput output = folder.run(api(), "0 quit\n", "", ":9999");
  EXPECT_EQ(output.code, 1);
  expectHas(output.errors, "display");
  EXPECT_EQ(std::count(output.errors.begin(), output.errors.end(), '\n'), 1) << output.errors;
}

// The loaders of Vulkan and OpenGL find no driver.
TEST_P(Viewer, WithoutADriverItSaysWhatToInstall) {
  if (GetParam() != kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  constexpr const char* kNoDrivers =
      "VK_ICD_FILENAMES=/none VK_DRIVER_FILES=/none LIBGL_DRIVERS_PATH=/none "
      "__GLX_VENDOR_LIBRARY_NAME=none __EGL_VENDOR_LIBRARY_FILENAMES=/none";
  const Folder folder;
  std::vector<std::string> choices = {""};
  for (const Api one : pelage::test::kWindowApis) choices.push_back(pelage::apiName(one));
  for (const std::string& chosen : choices) {
    const ProgramOutput output = folder.run(chosen, "0 quit\n", "", display(), kNoDrivers);
    EXPECT_EQ(output.code, 1) << output.errors;
    const bool vulkan = chosen != "gl", gl = chosen != "vulkan";
    EXPECT_EQ(output.errors.find("install mesa-vulkan-drivers") != std::string::npos, vulkan)
        << output.errors;
    EXPECT_EQ(output.errors.find("install libgl1-mesa-dri") != std::string::npos, gl)
        << output.errors;
  }
}

TEST_P(Viewer, AScriptThatIsWrongIsRefusedWithItsLine) {
  if (GetParam() != kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  const Folder folder;
  const ProgramOutput output = folder.run(api(), "0 quit\n0 jump\n");
  EXPECT_EQ(output.code, 1);
  expectHas(output.errors, "script.txt:2: there is no event 'jump'");
}

INSTANTIATE_TEST_SUITE_P(Apis, Viewer, testing::ValuesIn(pelage::test::kWindowApis),
                         pelage::test::apiTestName);

}  // namespace
