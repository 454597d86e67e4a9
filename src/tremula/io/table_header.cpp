#include "tremula/io/table_header.hpp"

#include <algorithm>
#include <cctype>

namespace tremula {
namespace {

char delimiter_of(std::string_view line) {
  for (const char delimiter : {'\t', ';', ','}) {
    if (line.find(delimiter) != std::string_view::npos) return delimiter;
  }
  return ' ';
}

std::string plain_name(std::string_view shown) {
  std::string plain;
  for (const char c : shown.substr(0, shown.find('('))) {  // "radius (m)": the unit is no part of the name
    if (std::isalnum(static_cast<unsigned char>(c)))
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

}  // namespace

bool is_table_header(std::string_view line) {
  const Fields fields = split_row(line, delimiter_of(line));
  for (std::size_t i = 0; i < std::min(fields.count, fields.at.size()); ++i) {
    if (fields.at[i].empty()) continue;
    double number;
    return !parse_number(fields.at[i], number) && std::isprint(static_cast<unsigned char>(fields.at[i][0]));
  }
  return false;
}

std::optional<std::size_t> TableHeader::find(std::initializer_list<std::string_view> names) const {
  const auto found = std::find_first_of(plain.begin(), plain.end(), names.begin(), names.end());
  if (found == plain.end()) return {};
  return static_cast<std::size_t>(found - plain.begin());
}

TableHeader parse_table_header(std::string_view line) {
  TableHeader header;
  header.delimiter = delimiter_of(line);
  const Fields fields = split_row(line, header.delimiter);
  for (std::size_t i = 0; i < std::min(fields.count, fields.at.size()); ++i) {
    header.shown.push_back(shown(fields.at[i]));
    header.plain.push_back(plain_name(fields.at[i]));
  }
  return header;
}

Fields split_row(std::string_view line, char delimiter) {
  if (delimiter != ' ') return split_at(line, delimiter);
  Fields fields = split_at_blanks(line);
  for (std::size_t i = 0; i < std::min(fields.count, fields.at.size()); ++i) {
    std::string_view& field = fields.at[i];
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
      field = field.substr(1, field.size() - 2);
  }
  return fields;
}

}  // namespace tremula
