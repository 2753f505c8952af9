#pragma once

// Embree 3.12, 3.13 and 4 alike: what of its interface differs between them and is used here. Only
// for the files that call Embree. SIGHTLINE_EMBREE_MAJOR is of the library that is linked
// (passes/rays/CMakeLists.txt), since the headers of both may be installed.

#if SIGHTLINE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#if RTC_VERSION_MAJOR < 3 || (RTC_VERSION_MAJOR == 3 && RTC_VERSION_MINOR < 12)
#error "Embree 3.12 or later is needed"
#endif

namespace sightline {

// What Embree hands to its callbacks; a caller's own struct begins with it.
#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
inline void start_query(EmbreeContext& context) { rtcInitRayQueryContext(&context); }
#else
using EmbreeContext = RTCIntersectContext;
inline void start_query(EmbreeContext& context) { rtcInitIntersectContext(&context); }
#endif

// Whether the rays of a packet go nearly the same way, which Embree makes use of.
enum class EmbreeRays { kAnyWay, kNeighbours };

#if RTC_VERSION_MAJOR >= 4
inline RTCIntersectArguments embree_arguments(EmbreeContext& context, EmbreeRays rays) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  if (rays == EmbreeRays::kNeighbours) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}
inline void intersect_1(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  RTCIntersectArguments arguments = embree_arguments(context, EmbreeRays::kAnyWay);
  rtcIntersect1(scene, &ray, &arguments);
}
inline void intersect_8(const int* valid, RTCScene scene, EmbreeContext& context, EmbreeRays way,
                        RTCRayHit8& rays) {
  RTCIntersectArguments arguments = embree_arguments(context, way);
  rtcIntersect8(valid, scene, &rays, &arguments);
}
#else
inline void intersect_1(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, &context, &ray);
}
inline void intersect_8(const int* valid, RTCScene scene, EmbreeContext& context, EmbreeRays way,
                        RTCRayHit8& rays) {
  if (way == EmbreeRays::kNeighbours) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, &rays);
}
#endif

}  // namespace sightline
