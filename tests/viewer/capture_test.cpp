// Recordings: pictures in a folder, a video through the program ffmpeg, times as CSV.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "capture/pass_times.h"
#include "capture/recording.h"
#include "interface/panels.h"
#include "png_file.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace {

using Path = std::filesystem::path;
using pelage::test::expectError;
using pelage::test::required;
using pelage::test::TestFolder;
using pelage::test::textOf;

sample::ByteImage picture(uint32_t width, uint32_t height, uint8_t value) {
  sample::ByteImage image;
  image.width = width;
  image.height = height;
  image.rgb.assign(size_t{3} * width * height, value);
  return image;
}

class Capture : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "bin");
    const char* const path = std::getenv("PATH");
    path_ = path != nullptr ? path : "";
  }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }
  /// Makes a program ffmpeg of a shell script, and makes it the only program on the PATH.
  void fakeFfmpeg(const std::string& script) const {
    const Path program = folder_ / "bin" / "ffmpeg";
    std::ofstream(program) << "#!/bin/sh\nPATH=" << path_ << "\n" << script;
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("PATH", (folder_ / "bin").c_str(), 1);
  }
  const TestFolder folder_;
  std::string path_;
};

TEST(FrameTimes, AreAveragedOverHalfASecond) {
  viewer::PassHistory history;
  viewer::FrameTimes times;
  times.add(0.1, history);
  EXPECT_EQ(times.text(), "10 frames/s");  // the first frame, without GPU times
  for (int i = 0; i < 40; ++i) {
    const pelage::PassTiming timings[] = {{"a", i % 2 == 0 ? 1.0 : 2.0}, {"b", 0.5}};
    history.add(timings);
    times.add(1.0 / 64, history);
    EXPECT_TRUE(i >= 31 || times.text() == "10 frames/s") << i;
  }
  EXPECT_EQ(times.text(), "64 frames/s, GPU 2.00 ms");
}

TEST_F(Capture, PicturesAreNumberedInTheirFolder) {
  auto recording = required(viewer::recordPictures(folder_ / "a" / "b"));
  for (uint8_t i = 1; i <= 3; ++i) ASSERT_TRUE((*recording)->add(picture(4 + i, 5, i)));
  EXPECT_TRUE((*recording)->finish());
  EXPECT_EQ((*recording)->pictures(), 3u);
  for (uint8_t i = 1; i <= 3; ++i) {
    const auto image = required(
        sample::readPng((folder_ / "a" / "b" / ("0000" + std::to_string(i) + ".png")).string()));
    EXPECT_EQ(image->rgb, picture(4 + i, 5, i).rgb);
  }
  std::ofstream(folder_ / "file") << "x";
  EXPECT_FALSE(viewer::recordPictures(folder_ / "file" / "c"));
}

// ffmpeg gets the size, all bytes, and the name of the file as one argument.
TEST_F(Capture, AVideoIsWhatFfmpegMakesOfThePictures) {
  fakeFfmpeg("for last; do :; done\necho \"$@\" > \"$last\"\ncat >> \"$last\"\n");
  ASSERT_TRUE(viewer::hasFfmpeg());
  const Path file = folder_ / "a video.mp4";
  auto recording = required(viewer::recordVideo(file));
  ASSERT_TRUE((*recording)->add(picture(64, 32, 65)));
  ASSERT_TRUE((*recording)->add(picture(64, 32, 66)));
  expectError((*recording)->add(picture(65, 32, 66)), "65 x 32");
  const auto finished = (*recording)->finish();
  EXPECT_TRUE(finished) << finished.error().message;
  const std::string text = textOf(file);
  EXPECT_NE(text.find("-s 64x32 -r 60"), std::string::npos) << text.substr(0, 200);
  const std::string pixels = std::string(64 * 32 * 3, 'A') + std::string(64 * 32 * 3, 'B');
  ASSERT_GT(text.size(), pixels.size());
  EXPECT_EQ(text.substr(text.size() - pixels.size()), pixels);
}

TEST_F(Capture, AVideoWithoutFfmpegOrWithABrokenOneSaysSo) {
  setenv("PATH", (folder_ / "nowhere").c_str(), 1);
  EXPECT_FALSE(viewer::hasFfmpeg());
  expectError(viewer::recordVideo(folder_ / "a.mp4"), "no ffmpeg on the PATH");

  fakeFfmpeg("exit 3\n");
  auto broken = required(viewer::recordVideo(folder_ / "a.mp4"));
  // These pictures are larger than the buffer of a pipe.
  bool added = true;
  for (int i = 0; i < 8 && added; ++i)
    added = static_cast<bool>((*broken)->add(picture(256, 256, 1)));
  EXPECT_FALSE(added);
  EXPECT_FALSE((*broken)->finish());
}

TEST_F(Capture, TimesAreALineForEachPass) {
  auto times = required(viewer::TimesFile::open(folder_ / "times.csv"));
  std::vector<pelage::PassTiming> timings(4);
  timings[0].name = timings[2].name = "solve";
  timings[1].name = "draw";
  timings[3].name = "unknown";
  timings[0].milliseconds = 0.25;
  timings[1].milliseconds = 2;
  timings[2].milliseconds = 0.5;
  timings[3].milliseconds = -1;
  times->add(7, timings);
  EXPECT_EQ(textOf(folder_ / "times.csv"),
            "frame,pass,passes,milliseconds\n7,draw,1,2.000000\n7,solve,2,0.750000\n");
  EXPECT_FALSE(viewer::TimesFile::open(folder_ / "no" / "times.csv"));
}

}  // namespace
