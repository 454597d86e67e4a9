#include "tremula/io/gust_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/table_header.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tremula {
namespace {

constexpr std::size_t most_rows = 1'000'000;
constexpr double fastest = 100;  // [m/s], as for MeanWind

struct Columns {
  char delimiter = ' ';
  std::size_t count = 0, time = 0, speed = 1;
  std::optional<std::size_t> heading = {};
};

Columns columns_of(std::string_view line, const std::string& place) {
  const TableHeader header = parse_table_header(line);
  Columns columns{.delimiter = header.delimiter, .count = header.shown.size()};
  if (!is_table_header(line)) {
    if (columns.count > 2) columns.heading = 2;
    if (columns.count >= 2 && columns.count <= 3) return columns;
    throw InputError(place, counted(columns.count, "column"), "time [s], speed [m/s] and heading [degrees]");
  }
  const auto time = header.find({"time", "times", "t", "ts"});
  const auto speed = header.find({"speed", "speedms", "u", "ums"});
  if (!time || !speed) {
    throw InputError(place, counted(columns.count, "column") + " beginning with " + header.shown.front(),
                     "a header with time_s, speed_m_s and, where the wind turns, heading_deg");
  }
  if (header.find({"direction", "directiondeg"}))
    throw InputError(place, "a direction", "a heading: where the wind blows to, counter-clockwise from x");
  columns.time = *time;
  columns.speed = *speed;
  columns.heading = header.find({"heading", "headingdeg", "headingdegrees"});
  return columns;
}

}  // namespace

GustScript read_gust_table(const std::string& path, double heading) {
  return read_gust_table(read_file(path), path, heading);
}

GustScript read_gust_table(std::string_view text, const std::string& path, double heading) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // UTF-8 says so itself
  TextLines lines{text};
  std::string_view line;
  GustScript script;
  std::optional<Columns> columns;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    if (!columns) {
      columns = columns_of(line, path + ":" + std::to_string(lines.number));
      if (is_table_header(line)) continue;
    }
    const Fields fields = split_row(line, columns->delimiter);
    const TableRow row{path, lines.number, fields};
    if (fields.count != columns->count || fields.count > fields.at.size()) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       std::to_string(columns->count) + " as in the first line");
    }
    if (script.rows.size() == most_rows)
      throw InputError(row.place(), "yet another row", "at most " + std::to_string(most_rows));
    GustRow read{.time = row.coordinate(columns->time, "time"),
                 .speed = row.finite(columns->speed, "speed"),
                 .heading = columns->heading ? row.coordinate(*columns->heading, "heading") : heading};
    if (!script.rows.empty() && read.time <= script.rows.back().time)
      row.reject(columns->time, "time",
                 "more than the " + shown(script.rows.back().time) + " s of the row before");
    if (read.speed < 0 || read.speed > fastest) row.reject(columns->speed, "speed", "0 to 100 m/s");
    script.rows.push_back(read);
  }
  if (script.rows.empty()) throw InputError(path, "no rows", "times, speeds and headings of a wind");
  if (std::ranges::all_of(script.rows, [](const GustRow& row) { return row.speed == 0; }))
    throw InputError(path, "no wind in any row", "a speed above 0 m/s");
  return script;
}

}  // namespace tremula
