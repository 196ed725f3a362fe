// The viewer in a window: scripts that orbit, pause, resize and quit; the pictures are those of
// hair, and the same in every run. The display is an Xvfb that the test starts.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "image.h"
#include "png_file.h"
#include "support/required_devices.h"

namespace {

using sample::ByteImage;

/// A display of its own, from the first test to the end of the program.
class Display {
 public:
  Display() {
    std::array<int, 2> ends = {-1, -1};
    if (pipe(ends.data()) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      const std::string number = std::to_string(ends[1]);
      close(ends[0]);
      execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "1280x1024x24",
             "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(ends[1]);
    char digit = 0;
    std::string number;
    while (read(ends[0], &digit, 1) == 1 && digit != '\n') number += digit;
    close(ends[0]);
    if (!number.empty()) name_ = ":" + number;
  }
  ~Display() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  const std::string& name() const { return name_; }

 private:
  pid_t process_ = -1;
  std::string name_;  // empty: there is none
};

const std::string& display() {
  static const Display kDisplay;
  return kDisplay.name();
}

std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// What a picture shows beside the backdrop.
struct Statistics {
  double drawnShare = 0;   ///< of the pixels
  double mean = 0;         ///< of these pixels' channels, 0..255
  double detailShare = 0;  ///< of these pixels: those unlike their right neighbor, as strands are
};

Statistics statisticsOf(const ByteImage& image, uint32_t first, uint32_t end) {
  pelage::RenderedImage empty;
  empty.width = image.width;
  empty.height = image.height;
  empty.pixels.resize(size_t{image.width} * image.height);
  sample::compositeOver(empty, {});
  const ByteImage backdrop = sample::encodeSrgb(empty);
  const auto difference = [](const uint8_t* a, const uint8_t* b) {
    int most = 0;
    for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a[c] - b[c]));
    return most;
  };
  size_t drawn = 0, detailed = 0;
  double sum = 0;
  for (size_t i = 0; i + 3 < image.rgb.size(); i += 3) {
    const size_t column = i / 3 % image.width;
    if (column < first || column >= end) continue;
    const uint8_t* pixel = &image.rgb[i];
    if (difference(pixel, &backdrop.rgb[i]) <= 4) continue;
    ++drawn;
    sum += (pixel[0] + pixel[1] + pixel[2]) / 3.0;
    detailed += difference(pixel, pixel + 3) > 12 ? 1 : 0;
  }
  Statistics result;
  result.drawnShare = static_cast<double>(drawn) /
                      (static_cast<double>(end - first) * static_cast<double>(image.height));
  if (drawn > 0) {
    result.mean = sum / static_cast<double>(drawn);
    result.detailShare = static_cast<double>(detailed) / static_cast<double>(drawn);
  }
  return result;
}

struct Output {
  int code = -1;
  std::string errors;
};

class Viewer : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (display().empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: Xvfb does not start";
    folder_ = std::filesystem::temp_directory_path() /
              ("pelage_viewer_" + std::to_string(getpid()) + "_" + GetParam());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }

  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  /// Runs a script in a window of 320 x 240.
  Output run(const std::string& script, const std::string& arguments = "",
             const std::string& displayName = display()) const {
    std::ofstream(file("script.txt")) << script;
    const std::string command = "cd '" + folder_.string() + "' && DISPLAY=" + displayName + " '" +
                                PELAGE_VIEWER + "' --api " + GetParam() +
                                " --validation --size 320x240 --cache none --script script.txt " +
                                arguments + " > stdout.txt 2> stderr.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(file("stderr.txt"))};
  }

  ByteImage picture(const std::string& name) const {
    const auto image = sample::readPng(file(name).string());
    EXPECT_TRUE(image) << image.error().message;
    return image ? *image : ByteImage{};
  }

  /// \param first, end the columns that it is in.
  void expectHair(const ByteImage& image, const char* name, uint32_t first = 0,
                  uint32_t end = 0) const {
    const Statistics s = statisticsOf(image, first, end > 0 ? end : image.width);
    EXPECT_TRUE(s.drawnShare > 0.15 && s.drawnShare < 0.95) << name << ": " << s.drawnShare;
    EXPECT_TRUE(s.mean > 20 && s.mean < 230) << name << ": " << s.mean;
    EXPECT_TRUE(s.detailShare > 0.1) << name << ": " << s.detailShare;
  }

  std::filesystem::path folder_;
};

// All in one script, because a start takes longer than a frame.
constexpr const char* kSession = R"(
0 key tab
0 key =
0 key =
0 screenshot start.png
2 screenshot moved.png
3 key space
3 screenshot paused.png
4 screenshot paused_later.png
5 move 160 120
5 press left
5 move 220 130
5 release left
5 screenshot orbited.png
6 key f
6 scroll 3
6 key .
6 screenshot near.png
7 resize 400 200
7 screenshot resized.png
8 quit
)";

TEST_P(Viewer, ShowsHairAndDoesWhatAScriptSays) {
  const Output first = run(kSession);
  ASSERT_EQ(first.code, 0) << first.errors;
  EXPECT_EQ(first.errors, "");
  const ByteImage start = picture("start.png"), paused = picture("paused.png");
  ASSERT_EQ(start.width, 320u);
  ASSERT_EQ(start.height, 240u);
  for (const char* name : {"start.png", "orbited.png", "near.png", "resized.png"})
    expectHair(picture(name), name);
  EXPECT_NE(start.rgb, picture("moved.png").rgb);
  EXPECT_EQ(paused.rgb, picture("paused_later.png").rgb);
  EXPECT_NE(paused.rgb, picture("orbited.png").rgb);
  EXPECT_NE(picture("orbited.png").rgb, picture("near.png").rgb);
  const ByteImage resized = picture("resized.png");
  EXPECT_EQ(resized.width, 400u);
  EXPECT_EQ(resized.height, 200u);

  std::vector<ByteImage> before;
  const char* const names[] = {"start.png", "orbited.png", "near.png", "resized.png"};
  for (const char* name : names) before.push_back(picture(name));
  const Output second = run(kSession);
  ASSERT_EQ(second.code, 0) << second.errors;
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(before[i].rgb, picture(names[i]).rgb) << names[i];
}

TEST_P(Viewer, ARecordingIsAScriptOfTheSameSession) {
  const char* const arguments = "--groom mohawk";
  const Output first =
      run("0 key tab\n0 move 100 100\n0 press right\n1 move 90 120\n1 release right\n1 scroll "
          "-1\n1 text 120\n2 resize 300 200\n3 screenshot picture.png\n",
          std::string(arguments) + " --record recorded.txt");
  ASSERT_EQ(first.code, 0) << first.errors;
  const ByteImage before = picture("picture.png");
  EXPECT_EQ(before.width, 300u);
  std::filesystem::remove(file("picture.png"));
  const Output second = run(contents(file("recorded.txt")), arguments);
  ASSERT_EQ(second.code, 0) << second.errors;
  EXPECT_EQ(before.rgb, picture("picture.png").rgb);
}

// The ball parts the hair, and the device may be lost meanwhile.
TEST_P(Viewer, ABallMovesHairAndALostDeviceComesBack) {
  const std::string still = "0 key tab\n0 key r\n";
  const std::string ball = "0 keydown control\n0 move 100 120\n0 press left\n2 move 120 120\n";
  const std::string loss = "3 key f9\n4 key enter\n";
  const std::string end = "5 screenshot picture.png\n";
  const char* const arguments = "--groom straight";
  ASSERT_EQ(run(still + end, arguments).code, 0);
  const ByteImage without = picture("picture.png");
  expectHair(without, "without a ball");
  ASSERT_EQ(run(still + ball + end, arguments).code, 0);
  const ByteImage with = picture("picture.png");
  EXPECT_NE(with.rgb, without.rgb);
  const Output output = run(still + ball + loss + end, arguments);
  ASSERT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  expectHair(picture("picture.png"), "behind the loss");
}

TEST_P(Viewer, ABrokenFileIsAMessageAndTheSceneStays) {
  std::ofstream(file("broken.tfx")) << "no hair at all";
  const Output output =
      run("0 key tab\n1 key space\n1 screenshot before.png\n2 drop broken.tfx\n3 screenshot "
          "message.png\n4 key escape\n6 screenshot after.png\n",
          "--groom mohawk");
  ASSERT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  const ByteImage before = picture("before.png");
  expectHair(before, "before.png");
  EXPECT_NE(before.rgb, picture("message.png").rgb);
  EXPECT_EQ(before.rgb, picture("after.png").rgb);
}

// Each view differs from the one before; behind the last one, the hair is as it was. Then a file is
// opened in the dialog by its name.
TEST_P(Viewer, LooksInsideAndOpensFiles) {
  std::ofstream(file("broken.tfx")) << "no hair at all";
  std::string script = "0 key tab\n1 key space\n1 screenshot 0.png\n";
  for (int view = 1; view <= 7; ++view)
    script += std::to_string(2 * view) + " key v\n" + std::to_string(2 * view + 1) +
              " screenshot " + std::to_string(view) + ".png\n";
  script += "16 key c\n16 screenshot contacts.png\n17 key c\n17 key o\n20 screenshot dialog.png\n";
  for (const char letter : std::string("broken.tfx"))
    script += "20 text " + std::to_string(static_cast<int>(letter)) + "\n";
  script += "22 key enter\n25 screenshot message.png\n26 key escape\n28 screenshot after.png\n";
  const Output output = run(script, "--groom straight --head-collider mesh");
  ASSERT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  const ByteImage hair = picture("0.png");
  expectHair(hair, "hair");
  for (int view = 1; view <= 7; ++view)
    EXPECT_NE(picture(std::to_string(view) + ".png").rgb,
              picture(std::to_string(view - 1) + ".png").rgb)
        << view;
  EXPECT_EQ(picture("7.png").rgb, hair.rgb);
  EXPECT_NE(picture("contacts.png").rgb, hair.rgb);
  EXPECT_NE(picture("dialog.png").rgb, hair.rgb);
  EXPECT_NE(picture("message.png").rgb, picture("dialog.png").rgb);
  EXPECT_EQ(picture("after.png").rgb, hair.rgb);
}

// Two solvers side by side; the statistics are those of the side that is chosen.
TEST_P(Viewer, ShowsTwoSidesAndOneAgain) {
  const Output output =
      run("0 key i\n0 key e\n1 screenshot panels.png\n2 key tab\n3 screenshot two.png\n"
          "4 resize 300 200\n4 screenshot resized.png\n5 key d\n5 screenshot one.png\n",
          "--groom straight --compare classic");
  ASSERT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  EXPECT_NE(picture("panels.png").rgb, picture("two.png").rgb);
  for (const char* name : {"two.png", "resized.png"}) {
    const ByteImage two = picture(name);
    expectHair(two, "left", 0, two.width / 2);
    expectHair(two, "right", two.width / 2, two.width);
  }
  expectHair(picture("one.png"), "one");
}

TEST_P(Viewer, WithoutADisplayItSaysSo) {
  const Output output = run("0 quit\n", "", ":9999");
  EXPECT_EQ(output.code, 1);
  EXPECT_NE(output.errors.find("display"), std::string::npos) << output.errors;
  EXPECT_EQ(std::count(output.errors.begin(), output.errors.end(), '\n'), 1) << output.errors;
}

TEST_P(Viewer, AScriptThatIsWrongIsRefusedWithItsLine) {
  const Output output = run("0 quit\n0 jump\n");
  EXPECT_EQ(output.code, 1);
  EXPECT_NE(output.errors.find("script.txt:2: there is no event 'jump'"), std::string::npos)
      << output.errors;
}

#ifdef PELAGE_TEST_VULKAN
INSTANTIATE_TEST_SUITE_P(Vulkan, Viewer, testing::Values("vulkan"));
#endif
#ifdef PELAGE_TEST_GL
INSTANTIATE_TEST_SUITE_P(Gl, Viewer, testing::Values("gl"));
#endif

}  // namespace
