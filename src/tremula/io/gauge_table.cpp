#include "tremula/io/gauge_table.hpp"

#include "tremula/base/check.hpp"
#include "tremula/io/append_number.hpp"
#include "tremula/io/finite.hpp"

namespace tremula {
namespace {

void check_series(std::span<const GaugeSeries> gauges) {
  check_at_least("gauges", static_cast<std::ptrdiff_t>(gauges.size()), 1);
  const Eigen::Index samples = gauges[0].strain.size();
  check_at_least("samples of a gauge", samples, 1);
  for (const GaugeSeries& one : gauges) {
    if (one.gauge.find_first_of(",\"\r\n") != std::string::npos)
      throw InputError("name of a gauge", one.gauge, "no comma, quote or end of line in it");
    if (one.period != gauges[0].period)
      throw InputError("period of gauge " + one.gauge, std::to_string(one.period),
                       std::to_string(gauges[0].period) + " s");
    for (const Eigen::VectorXd* column : {&one.bending_moment, &one.along_wind, &one.across_wind, &one.shear,
                                          &one.axial, &one.torsion, &one.strain}) {
      check_equal("samples of a gauge", column->size(), samples);
      check_finite("gauge " + one.gauge, *column);
    }
  }
}

}  // namespace

std::string encode_gauge_table(std::span<const GaugeSeries> gauges, std::span<const int> frames) {
  check_series(gauges);
  const auto samples = static_cast<int>(gauges[0].strain.size());
  std::string text =
      "frame,time_s,gauge,bending_moment_n_m,along_n_m,across_n_m,shear_n,axial_n,torsion_n_m,strain\n";
  for (const int frame : frames) {
    if (frame < 0 || frame > samples)
      throw InputError("frame", std::to_string(frame), "0 to " + std::to_string(samples));
    const Eigen::Index sample = frame % samples;
    for (const GaugeSeries& one : gauges) {
      append_number(text, frame, ',');
      append_number(text, frame * one.period / samples, ',');
      text += one.gauge + ',';
      append_number(text, one.bending_moment[sample], ',');
      append_number(text, one.along_wind[sample], ',');
      append_number(text, one.across_wind[sample], ',');
      append_number(text, one.shear[sample], ',');
      append_number(text, one.axial[sample], ',');
      append_number(text, one.torsion[sample], ',');
      append_number(text, one.strain[sample], '\n');
    }
  }
  return text;
}

}  // namespace tremula
