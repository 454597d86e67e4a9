#include "tremula/io/page_block.hpp"

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

std::string page_block(std::string_view letters, const nlohmann::ordered_json& document,
                       const std::string& numbers) {
  std::string json = document.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string block(letters);
  append_numbers(block, std::vector<std::uint32_t>{static_cast<std::uint32_t>(json.size())});
  return block + json + numbers;
}

}  // namespace tremula
