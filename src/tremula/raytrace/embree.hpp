// Embree, of which versions 3 and 4 differ in how they are asked.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace tremula {

// What goes with a ray to the shapes it meets; more may follow it in memory (Embree hands the pointer on).
#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
#else
using EmbreeContext = RTCIntersectContext;
#endif

inline void find_closest(RTCScene scene, EmbreeContext& context, RTCRayHit& query) {
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &query, &arguments);
#else
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
}

// query.tfar is below 0 then where something is in the way.
inline void find_any(RTCScene scene, EmbreeContext& context, RTCRay& query) {
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  rtcOccluded1(scene, &query, &arguments);
#else
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
#endif
}

}  // namespace tremula
