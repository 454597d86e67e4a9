// Stands in where Embree was not there when the library was built.
#include "tremula/raytrace/raytrace.hpp"

#include "tremula/base/error.hpp"

namespace tremula {

struct Tracer::Impl {};

bool can_trace() { return false; }

Tracer::Tracer(TraceScene) {
  throw Error(
      "pictures are traced by Embree (libembree-dev), and this tremula was built without it "
      "(TREMULA_EMBREE)");
}
Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

TracedImage Tracer::trace(const std::function<Camera(double time)>&, double, const TraceOptions&,
                          const std::function<void(double)>&, TraceCounts*) const {
  return {};
}

}  // namespace tremula
