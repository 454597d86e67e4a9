#include "tremula/io/profile_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

namespace tremula {
namespace {

constexpr std::size_t most_rows = 100'000;
constexpr double fastest = 100;  // [m/s], as for MeanWind

Fields split(std::string_view line, char delimiter) {
  return delimiter == ' ' ? split_at_blanks(line) : split_at(line, delimiter);
}

// A column's name in lower case and its unit with / for _: "Speed [m/s]" and "speed_m_s" are "speed" in
// "m/s".
struct ColumnName {
  std::string name, unit;
};

ColumnName column_name(std::string_view field) {
  ColumnName column;
  const std::size_t end = field.find_first_of(" _[(");
  for (const char c : field.substr(0, end))
    column.name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (end == std::string_view::npos) return column;
  for (const char c : field.substr(end)) {
    const bool frame = c == ' ' || c == '[' || c == ']' || c == '(' || c == ')';
    if (frame || (c == '_' && column.unit.empty())) continue;
    column.unit += c == '_' ? '/' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return column;
}

// Where a quantity stands, by any of its names. Refuses other units than those.
std::optional<std::size_t> find_column(const std::vector<ColumnName>& header, const std::string& place,
                                       const std::vector<std::string>& names,
                                       const std::vector<std::string>& units) {
  for (std::size_t i = 0; i < header.size(); ++i) {
    if (std::find(names.begin(), names.end(), header[i].name) == names.end()) continue;
    if (std::find(units.begin(), units.end(), header[i].unit) == units.end()) {
      throw InputError(place,
                       "the column " + shown(header[i].name) +
                           (header[i].unit.empty() ? " has no unit" : " is in " + shown(header[i].unit)),
                       names.front() + " [" + units.front() + "]");
    }
    return i;
  }
  return {};
}

struct Columns {
  std::size_t count = 0, height = 0, speed = 0;
  std::optional<std::size_t> direction, heading;
};

Columns columns_of(std::string_view line, char delimiter, const std::string& place) {
  std::vector<ColumnName> header;
  const Fields fields = split(line, delimiter);
  for (std::size_t i = 0; i < std::min(fields.count, fields.at.size()); ++i) {
    const bool only_unit =
        delimiter == ' ' && !header.empty() && (fields.at[i][0] == '[' || fields.at[i][0] == '(');
    if (only_unit) {
      header.back() = column_name(header.back().name + " " + std::string(fields.at[i]));
    } else {
      header.push_back(column_name(fields.at[i]));
    }
  }
  const auto height = find_column(header, place, {"height", "z"}, {"m"});
  const auto speed = find_column(header, place, {"speed", "u"}, {"m/s"});
  if (!height || !speed) {
    throw InputError(place, counted(fields.count, "column") + " beginning with " + shown(fields.at[0]),
                     "a header with height_m, speed_m_s and, where the wind veers, direction_deg");
  }
  const std::vector<std::string> degrees{"deg", "degrees", "°"};
  const Columns columns{header.size(), *height, *speed, find_column(header, place, {"direction"}, degrees),
                        find_column(header, place, {"heading"}, degrees)};
  if (columns.direction && columns.heading)
    throw InputError(place, "direction and heading", "one of them: they turn in opposite senses");
  return columns;
}

}  // namespace

std::vector<ProfileRow> read_profile_table(const std::string& path) {
  return read_profile_table(read_file(path), path);
}

std::vector<ProfileRow> read_profile_table(std::string_view text, const std::string& path) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // UTF-8 says so itself
  TextLines lines{text};
  std::string_view line;
  std::vector<ProfileRow> rows;
  std::optional<Columns> columns;
  char delimiter = ' ';
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    if (!columns) {
      for (const char candidate : {'\t', ';', ','}) {
        if (line.find(candidate) != std::string_view::npos) delimiter = candidate;
      }
      columns = columns_of(line, delimiter, path + ":" + std::to_string(lines.number));
      continue;
    }
    const Fields fields = split(line, delimiter);
    const TableRow row{path, lines.number, fields};
    if (fields.count != columns->count || fields.count > fields.at.size()) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       std::to_string(columns->count) + " as in the header");
    }
    if (rows.size() == most_rows)
      throw InputError(row.place(), "yet another row", "at most " + std::to_string(most_rows));
    ProfileRow read{.height = row.coordinate(columns->height, "height"),
                    .speed = row.finite(columns->speed, "speed")};
    if (read.height < 0) row.reject(columns->height, "height", "0 m or more");
    if (!rows.empty() && read.height <= rows.back().height)
      row.reject(columns->height, "height",
                 "more than the " + shown(rows.back().height) + " of the row before");
    if (read.speed < 0 || read.speed > fastest) row.reject(columns->speed, "speed", "0 to 100 m/s");
    if (columns->direction) read.turn = -row.coordinate(*columns->direction, "direction");
    if (columns->heading) read.turn = row.coordinate(*columns->heading, "heading");
    if (!rows.empty()) read.turn = rows.back().turn + std::remainder(read.turn - rows.back().turn, 360);
    rows.push_back(read);
  }
  if (rows.size() < 2)
    throw InputError(path, counted(rows.size(), "row") + " of a profile", "a header and two rows or more");
  return rows;
}

}  // namespace tremula
