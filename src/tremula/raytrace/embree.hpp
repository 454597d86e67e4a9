// Embree, of which versions 3 and 4 differ in how they are asked.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace tremula {

inline void find_closest(RTCScene scene, RTCRayHit& query) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
}

// query.tfar is below 0 then where something is in the way.
inline void find_any(RTCScene scene, RTCRay& query) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
#endif
}

}  // namespace tremula
