#include "clips.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

namespace tremula::cli {

std::vector<NamedWind> parse_clips(const std::vector<std::string>& texts) {
  constexpr double fastest = 100;  // [m/s]
  std::vector<NamedWind> clips;
  for (const std::string& text : texts) {
    const auto refuse = [&](const char* wanted) { throw InputError("--clip", "'" + text + "'", wanted); };
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0) refuse("a name and a wind speed [m/s], such as calm:2");
    NamedWind clip{text.substr(0, colon), -1};
    const char *begin = text.data() + colon + 1, *end = text.data() + text.size();
    const auto parsed = std::from_chars(begin, end, clip.wind_speed);
    if (parsed.ec != std::errc{} || parsed.ptr != end ||
        !(clip.wind_speed >= 0 && clip.wind_speed <= fastest))
      refuse("a wind speed from 0 to 100 m/s behind the colon");
    if (std::ranges::any_of(clips, [&](const NamedWind& other) { return other.name == clip.name; }))
      refuse("a name that no other clip has");
    clips.push_back(std::move(clip));
  }
  return clips;
}

Motion lean_alone(Motion motion) {
  Eigen::MatrixXd one = Eigen::MatrixXd::Zero(1, motion.coordinates.cols());
  for (std::size_t c = 0; c < motion.basis.kind.size(); ++c)
    one(0, static_cast<Eigen::Index>(c)) = motion.basis.kind[c] == ShapeKind::lean ? 1 : 0;
  motion.coordinates = std::move(one);
  return motion;
}

}  // namespace tremula::cli
