#include "tremula/io/film.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/wait.h>
#include <unistd.h>

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"

namespace tremula {
namespace {

std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  std::array<char, 4096> bytes;
  for (std::size_t got = 0; (got = std::fread(bytes.data(), 1, bytes.size(), pipe)) > 0;)
    text.append(bytes.data(), got);
  ::pclose(pipe);
  return text;
}

bool has_ffmpeg() {
  return std::system("ffmpeg -version > /dev/null 2>&1 && ffprobe -version > /dev/null 2>&1") == 0;
}

// A bar that goes round once in a film, on a ground that has a colour of its own in every corner.
Image frame_of(int k, int frames, int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool bar = (x * frames / width - k + frames) % frames < 2;
      const bool right = x >= width / 2, low = y >= height / 2;
      const std::array<std::uint8_t, 3> ground = {std::uint8_t(right ? 200 : 40),
                                                  std::uint8_t(low ? 180 : 60),
                                                  std::uint8_t(right == low ? 160 : 80)};
      for (const std::uint8_t channel : ground) image.rgb.push_back(bar ? 250 : channel);
    }
  }
  return image;
}

class FilmTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("tremula-film-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    if (const char* path = std::getenv("PATH")) path_before_ = path;
  }
  void TearDown() override {
    ::setenv("PATH", path_before_.c_str(), 1);
    std::filesystem::remove_all(folder_);
  }
  std::string in_folder(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }
  void make(const std::string& path, const FilmSettings& settings) const {
    Film film(path, settings);
    for (int k = 0; k < settings.frames; ++k)
      film.add(frame_of(k, settings.frames, settings.width, settings.height));
    film.finish();
  }
  // Its frames as a second run of ffmpeg sees them, one after the other.
  static std::string decoded(const std::string& path) {
    return output_of("ffmpeg -v error -i " + path + " -f rawvideo -pix_fmt rgb24 -vsync passthrough -");
  }
  // An ffmpeg of ours, found before the real one.
  void stand_in(const std::string& script) const {
    std::filesystem::create_directories(folder_ / "bin");
    const std::string program = in_folder("bin/ffmpeg");
    std::ofstream(program) << "#!/bin/sh\n" << script;
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    ::setenv("PATH", (in_folder("bin") + ":" + path_before_).c_str(), 1);
  }

  std::filesystem::path folder_;
  std::string path_before_;
};

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(FilmTest, HasEveryFrameAtItsTimeAndItsColours) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  const FilmSettings settings{96, 64, 20, 25, {}};
  for (const char* extension : {".mp4", ".webm", ".gif"}) {
    const std::string path = in_folder(std::string("film") + extension);
    make(path, settings);
    EXPECT_EQ(files(), 1U) << "something is left beside it";
    const std::string said = output_of(
        "ffprobe -v error -count_frames -show_entries "
        "stream=width,height,nb_read_frames,avg_frame_rate:format=duration -of csv=p=0 " +
        path);
    EXPECT_THAT(said, testing::StartsWith("96,64,25/1,20\n")) << extension;
    EXPECT_NEAR(std::atof(said.substr(said.find('\n') + 1).c_str()), 20.0 / 25, 1e-3) << extension;
    const std::string frames = decoded(path);
    ASSERT_EQ(frames.size(), 20U * 96 * 64 * 3) << extension;
    double worst = 0;
    for (int k = 0; k < 20; ++k) {
      const Image wanted = frame_of(k, 20, 96, 64);
      double difference = 0;
      for (std::size_t i = 0; i < wanted.rgb.size(); ++i) {
        const auto found =
            static_cast<std::uint8_t>(frames[static_cast<std::size_t>(k) * wanted.rgb.size() + i]);
        difference += std::abs(found - wanted.rgb[i]) / static_cast<double>(wanted.rgb.size());
      }
      worst = std::max(worst, difference);
    }
    EXPECT_LT(worst, 6) << extension;  // of 255; one frame off would be 20 and more
    std::filesystem::remove(path);
  }
}

TEST_F(FilmTest, HasTheSameBytesEveryTime) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  for (const char* extension : {".mp4", ".webm", ".gif"}) {
    const std::string one = in_folder(std::string("one") + extension),
                      two = in_folder(std::string("two") + extension);
    for (const std::string& path : {one, two}) make(path, {64, 48, 8, 24, {}});
    EXPECT_EQ(read_file(one), read_file(two)) << extension;
  }
}

TEST_F(FilmTest, BeginsWithItsIndexAndAGifRepeatsForEver) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  make(in_folder("film.mp4"), {64, 48, 8, 24, {}});
  const std::string mp4 = read_file(in_folder("film.mp4"));
  EXPECT_LT(mp4.find("moov"), mp4.find("mdat"));
  make(in_folder("film.gif"), {64, 48, 8, 24, {}});
  const std::string gif = read_file(in_folder("film.gif"));
  const std::size_t application = gif.find("NETSCAPE2.0");
  ASSERT_NE(application, std::string::npos);
  EXPECT_EQ(gif.substr(application + 11, 4), std::string("\x03\x01\0\0", 4));  // 0 times: for ever
}

TEST_F(FilmTest, OfOddSizeIsOnePixelLargerWhereColoursTakeTwo) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  for (const auto& [extension, size] : {std::pair{".mp4", "66,50"}, {".webm", "66,50"}, {".gif", "65,49"}}) {
    const std::string path = in_folder(std::string("odd") + extension);
    make(path, {65, 49, 3, 10, {}});
    EXPECT_THAT(output_of("ffprobe -v error -show_entries stream=width,height -of csv=p=0 " + path),
                testing::StartsWith(size));
  }
}

TEST_F(FilmTest, KeepsTheRatesOfTelevisionExact) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  for (const auto& [rate, ratio] :
       {std::pair{29.97, "30000/1001"}, {23.976, "24000/1001"}, {12.5, "25/2"}, {60.0, "60/1"}}) {
    const std::string path = in_folder("rate.mp4");
    make(path, {64, 48, 6, rate, {}});
    EXPECT_THAT(output_of("ffprobe -v error -show_entries stream=r_frame_rate -of csv=p=0 " + path),
                testing::StartsWith(ratio));
  }
}

TEST_F(FilmTest, ReplacesAnOlderOneOnlyWhenItIsWhole) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  const std::string path = in_folder("film.mp4");
  write_file_atomically(path, "the one before");
  {
    Film film(path, {64, 48, 3, 25, {}});
    film.add(frame_of(0, 3, 64, 48));
    EXPECT_THAT(message_of([&] { film.finish(); }), testing::HasSubstr("1 frames, wanted 3"));
  }
  EXPECT_EQ(read_file(path), "the one before");
  EXPECT_EQ(files(), 1U);
  make(path, {64, 48, 3, 25, {}});
  EXPECT_GT(read_file(path).size(), 500U);
}

TEST_F(FilmTest, WithoutFfmpegSaysWhatToInstallBeforeAnyFrameIsMade) {
  ::setenv("PATH", folder_.c_str(), 1);
  EXPECT_EQ(message_of([&] {
              const Film film(in_folder("film.mp4"), {64, 48, 3, 25, {}});
            }),
            in_folder("film.mp4") +
                ": .mp4 needs the program ffmpeg, which is not there: install it (apt install ffmpeg), "
                "or write frames/%04d.png");
  EXPECT_EQ(files(), 0U);
}

TEST_F(FilmTest, SaysInOneLineWhatFfmpegSaysAndLeavesNoFile) {
  stand_in(
      "echo '[libx264 @ 0x5581] out of luck' >&2\necho 'and more' >&2\nhead -c 100 > /dev/null\nexit 3\n");
  const std::string message = message_of([&] {
    Film film(in_folder("film.mp4"), {640, 480, 100, 25, {}});
    for (int k = 0; k < 100; ++k) film.add(frame_of(k, 100, 640, 480));
    film.finish();
  });
  EXPECT_EQ(message, in_folder("film.mp4") + ": ffmpeg fails: out of luck");
  EXPECT_EQ(files(), 1U);  // bin
  stand_in("cat > /dev/null\nexit 7\n");
  EXPECT_EQ(message_of([&] {
              make(in_folder("film.mp4"), {64, 48, 3, 25, {}});
            }),
            in_folder("film.mp4") + ": ffmpeg fails with exit code 7");
  EXPECT_EQ(files(), 1U);
}

TEST_F(FilmTest, ThatIsGivenUpLeavesNoFileAndNoProcess) {
  stand_in("echo $$ > " + in_folder("bin/process") + "\nexec cat > /dev/null\n");
  {
    Film film(in_folder("film.mp4"), {64, 48, 3, 25, {}});
    film.add(frame_of(0, 3, 64, 48));
  }
  EXPECT_EQ(files(), 1U);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // no child, not even a dead one
}

TEST_F(FilmTest, RefusesFramesOfAnotherSizeAndOneTooMany) {
  stand_in("cat > /dev/null\n");
  Film film(in_folder("film.webm"), {64, 48, 1, 25, {}});
  EXPECT_THROW(film.add(frame_of(0, 1, 64, 47)), InputError);
  EXPECT_THROW(film.add({64, 48, {}}), InputError);
  film.add(frame_of(0, 1, 64, 48));
  EXPECT_THROW(film.add(frame_of(0, 1, 64, 48)), InputError);
}

TEST_F(FilmTest, RefusesSettingsThatNoFilmHas) {
  const auto refuse = [&](const std::string& name, const FilmSettings& settings) {
    EXPECT_THROW(Film(in_folder(name), settings), InputError) << name;
  };
  refuse("film.avi", {64, 48, 3, 25, {}});
  refuse("film.mp4", {8, 48, 3, 25, {}});
  refuse("film.mp4", {64, 48, 0, 25, {}});
  refuse("film.mp4", {64, 48, 3, std::nan(""), {}});
  refuse("film.gif", {64, 48, 3, 60, {}});
  refuse("film.mp4", {64, 48, 3, 25, 52});
  EXPECT_THROW(Film("/dev/null.mp4/film.mp4", {64, 48, 3, 25, {}}), Error);
  EXPECT_EQ(files(), 0U);
}

TEST(IsFilm, GoesByTheExtension) {
  for (const char* path : {"a.mp4", "b/c.webm", "d.e.gif"}) EXPECT_TRUE(is_film(path));
  for (const char* path : {"a.png", "mp4", ".mp4", "a.mp4/b", "a.MP4"}) EXPECT_FALSE(is_film(path));
}

}  // namespace
}  // namespace tremula
