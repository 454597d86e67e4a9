#include "tremula/io/film.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/io/atomic_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace tremula {
namespace {

std::string extension_of(const std::string& path) { return std::filesystem::path(path).extension().string(); }

std::string reason(int error) { return std::system_category().message(error); }

struct Descriptor {
  int number = -1;
  explicit Descriptor(int opened = -1) : number(opened) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

void check(const std::string& what, double found, double low, double high, const std::string& wanted) {
  if (found >= low && found <= high) return;
  throw InputError(what, number_text(found), wanted);
}

void check(const std::string& path, const FilmSettings& settings) {
  if (!is_film(path)) throw InputError(path, "extension '" + extension_of(path) + "'", ".mp4, .webm or .gif");
  const bool gif = extension_of(path) == ".gif";
  for (const int size : {settings.width, settings.height})
    check(path + ": pixels", size, 16, 8192, "16 to 8192");
  check(path + ": frames", settings.frames, 1, 1e6, "1 to 1000000");
  check(path + ": frames per second", settings.frame_rate, 1e-3, gif ? 50 : 240,
        gif ? "0.001 to 50" : "0.001 to 240");
  const int most = extension_of(path) == ".mp4" ? 51 : 63;
  if (settings.crf) check(path + ": crf", *settings.crf, 0, most, "0 to " + std::to_string(most));
}

// "25", "30000/1001": rates of television by their names, others to a thousandth.
std::string ratio_of(double rate) {
  for (const int nominal : {24, 30, 48, 60, 120}) {
    if (std::abs(rate - nominal / 1.001) < 2e-3) return std::to_string(nominal) + "000/1001";
  }
  const long thousandths = std::max(std::lround(rate * 1000), 1L);
  return thousandths % 1000 == 0 ? std::to_string(thousandths / 1000) : std::to_string(thousandths) + "/1000";
}

struct Size {
  int width, height;
};

Size size_in_file(const std::string& path, const FilmSettings& settings) {
  if (extension_of(path) == ".gif") return {settings.width, settings.height};
  return {settings.width + settings.width % 2, settings.height + settings.height % 2};
}

constexpr int film_descriptor = 3;  // of the unfinished file, in ffmpeg

std::vector<std::string> arguments(const std::string& path, const FilmSettings& settings) {
  const Size size = size_in_file(path, settings);
  std::vector<std::string> list = {"ffmpeg",
                                   "-hide_banner",
                                   "-nostdin",
                                   "-loglevel",
                                   "error",
                                   "-y",
                                   "-f",
                                   "rawvideo",
                                   "-pixel_format",
                                   "rgb24",
                                   "-video_size",
                                   std::to_string(size.width) + "x" + std::to_string(size.height),
                                   "-framerate",
                                   ratio_of(settings.frame_rate),
                                   "-i",
                                   "pipe:0"};
  const auto add = [&](std::initializer_list<std::string> more) { list.insert(list.end(), more); };
  const std::string extension = extension_of(path);
  if (extension == ".gif") {
    const std::size_t bytes = 3 * static_cast<std::size_t>(size.width) *
                              static_cast<std::size_t>(size.height) *
                              static_cast<std::size_t>(settings.frames);
    const bool one = bytes <= most_for_palette;
    add({"-filter_complex",
         std::string("split[a][b];[a]palettegen=stats_mode=") + (one ? "diff" : "single") +
             "[p];[b][p]paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle" + (one ? "" : ":new=1"),
         "-loop", "0", "-f", "gif"});
  } else {
    add({"-vf",
         "scale=out_color_matrix=bt709:out_range=tv:flags=bicubic+accurate_rnd+full_chroma_int+bitexact,"
         "format=yuv420p",
         "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"});
    if (extension == ".mp4") {
      add({"-c:v", "libx264", "-preset", "medium", "-crf", std::to_string(settings.crf.value_or(20)),
           "-movflags", "+faststart", "-f", "mp4"});
    } else {
      add({"-c:v", "libvpx-vp9", "-b:v", "0", "-crf", std::to_string(settings.crf.value_or(32)), "-deadline",
           "good", "-cpu-used", "3", "-row-mt", "0", "-f", "webm"});
    }
  }
  // The bytes of H.264 and VP9 depend on the number of threads.
  add({"-an", "-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-threads", "2",
       "/proc/self/fd/" + std::to_string(film_descriptor)});
  return list;
}

// ffmpeg as a child: reads from `input`, writes messages to `messages` and the film to `film`. The process,
// or 0 where there is no such program.
pid_t spawn(const std::string& path, std::vector<std::string> words, int input, int messages, int film) {
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, film, film_descriptor);
  pid_t process = 0;
  const int error = ::posix_spawnp(&process, "ffmpeg", &actions, nullptr, list.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT || error == EACCES || error == ENOTDIR) return 0;
  if (error != 0) throw Error(path + ": ffmpeg cannot be started: " + reason(error));
  return process;
}

// The first line that says something, without the "[libx264 @ 0x5581…] " before it.
std::string first_line(int file) {
  std::array<char, 4096> bytes;
  const ssize_t got = ::pread(file, bytes.data(), bytes.size(), 0);
  const std::string text(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  std::size_t begin = text.find_first_not_of(" \r\n");
  if (begin == std::string::npos) return {};
  std::string line = text.substr(begin, text.find_first_of("\r\n", begin) - begin);
  if (const std::size_t end = line.find("] "); line.starts_with('[') && end != std::string::npos)
    line.erase(0, end + 2);
  return line;
}

}  // namespace

bool is_film(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".mp4" || extension == ".webm" || extension == ".gif";
}

struct Film::Process {
  std::string path;
  FilmSettings settings;
  AtomicFile file;
  Descriptor messages, frames;
  pid_t process = 0;
  int added = 0;

  Process(const std::string& to, const FilmSettings& set);
  ~Process() {
    frames.close();
    if (process == 0) return;
    ::kill(process, SIGKILL);
    wait();
  }
  int wait();
  void send(const std::uint8_t* bytes, std::size_t size);
  [[noreturn]] void fail(int code);
};

Film::Process::Process(const std::string& to, const FilmSettings& set) : path(to), settings(set), file(to) {
  if (file.descriptor() < 0)
    throw InputError(path, "is no file", "a file, as films are not written from front to back");
  // Copies above what the child's own descriptors replace.
  const auto copy_above = [](int number) { return ::fcntl(number, F_DUPFD_CLOEXEC, 10); };
  const Descriptor memory(::memfd_create("messages of ffmpeg", MFD_CLOEXEC));
  messages.number = copy_above(memory.number);
  int ends[2] = {-1, -1};
  // A socket, as a write to a pipe that nobody reads any more would end this program.
  if (messages.number < 0 || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw Error(path + ": ffmpeg cannot be started: " + reason(errno));
  const Descriptor ours(ends[0]), theirs(ends[1]);
  frames.number = copy_above(ours.number);
  const Descriptor input(copy_above(theirs.number)), film(copy_above(file.descriptor()));
  if (frames.number < 0 || input.number < 0 || film.number < 0)
    throw Error(path + ": ffmpeg cannot be started: " + reason(errno));
  process = spawn(path, arguments(path, settings), input.number, messages.number, film.number);
  if (process == 0) {
    throw Error(path + ": " + extension_of(path) +
                " needs the program ffmpeg, which is not there: install it (apt install ffmpeg), or write "
                "frames/%04d.png");
  }
}

// Its exit code; above 128 the signal that ended it.
int Film::Process::wait() {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  process = 0;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void Film::Process::fail(int code) {
  const std::string said = first_line(messages.number);
  throw Error(path + ": ffmpeg fails" +
              (said.empty() ? " with exit code " + std::to_string(code) : ": " + said));
}

void Film::Process::send(const std::uint8_t* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = ::send(frames.number, bytes, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {  // it has ended
      frames.close();
      fail(wait());
    }
    bytes += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

Film::Film(const std::string& path, const FilmSettings& settings) {
  check(path, settings);
  process_ = std::make_unique<Process>(path, settings);
}

Film::~Film() = default;

void Film::add(const Image& frame) {
  Process& p = *process_;
  const std::string place = p.path + ": frame " + std::to_string(p.added);
  const std::size_t row = 3 * static_cast<std::size_t>(p.settings.width);
  if (frame.width != p.settings.width || frame.height != p.settings.height ||
      frame.rgb.size() != row * static_cast<std::size_t>(frame.height)) {
    throw InputError(place, std::to_string(frame.width) + " x " + std::to_string(frame.height) + " pixels",
                     std::to_string(p.settings.width) + " x " + std::to_string(p.settings.height));
  }
  if (p.added == p.settings.frames)
    throw InputError(place, "is one more", std::to_string(p.added) + " frames");
  const Size size = size_in_file(p.path, p.settings);
  if (size.width == frame.width && size.height == frame.height) {
    p.send(frame.rgb.data(), frame.rgb.size());
  } else {
    std::vector<std::uint8_t> wide;
    for (int y = 0; y < size.height; ++y) {
      const std::uint8_t* from = frame.pixel(0, std::min(y, frame.height - 1));
      wide.insert(wide.end(), from, from + row);
      if (size.width > frame.width) wide.insert(wide.end(), from + row - 3, from + row);
    }
    p.send(wide.data(), wide.size());
  }
  ++p.added;
}

void Film::finish() {
  Process& p = *process_;
  if (p.added != p.settings.frames)
    throw InputError(p.path, std::to_string(p.added) + " frames", std::to_string(p.settings.frames));
  p.frames.close();
  const int code = p.wait();
  if (code != 0) p.fail(code);
  p.file.commit();
}

}  // namespace tremula
