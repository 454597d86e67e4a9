#include "tremula/io/page_block.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tremula {

nlohmann::ordered_json facts_json(const LoopFacts& facts, double period) {
  return {{"period_s", period},
          {"frames_per_second", facts.frames_per_second},
          {"wind_speed_m_s", facts.wind_speed},
          {"heading_deg", facts.heading},
          {"seed", facts.seed},
          {"frequencies_hz", nlohmann::ordered_json::array()}};
}

nlohmann::ordered_json axes_json(const TimeAxis& loop, const FieldPlane& plane, double heading,
                                 double speed) {
  for (const double number : {heading, speed, plane.first_column, plane.spacing})
    check_finite("page: field", number);
  return {{"samples", loop.sample_count}, {"columns", plane.columns}, {"first_column_m", plane.first_column},
          {"spacing_m", plane.spacing},   {"heading_deg", heading},   {"gust_speed_m_s", speed}};
}

void append_field(const TravellingField& field, std::size_t kept, const char* name,
                  nlohmann::ordered_json& document, std::string& bytes) {
  constexpr double full = 32767;
  double most = 0;
  for (const auto& value : field.values) {
    check_finite("page: " + std::string(name), std::span<const float>(value));
    for (std::size_t k = 0; k < kept; ++k) most = std::max(most, std::abs(static_cast<double>(value[k])));
  }
  const double step = most / full;
  std::vector<std::int16_t> numbers;
  numbers.reserve(kept * field.values.size());
  for (const auto& value : field.values) {
    for (std::size_t k = 0; k < kept; ++k) {
      const double steps = most > 0 ? static_cast<double>(value[k]) / step : 0;
      numbers.push_back(static_cast<std::int16_t>(std::lround(steps)));
    }
  }
  append_part(numbers, kept, name, document, bytes);
  document[name]["step_m"] = step;
}

std::string page_block(std::string_view letters, const nlohmann::ordered_json& document,
                       const std::string& numbers) {
  std::string json = document.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string block(letters);
  append_numbers(block, std::vector<std::uint32_t>{static_cast<std::uint32_t>(json.size())});
  return block + json + numbers;
}

}  // namespace tremula
