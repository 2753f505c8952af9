#pragma once

namespace sightline {

// CPU time of this process so far, all threads, user and system.
double process_cpu_s();

// The largest memory that this process had since reset_peak_memory(); since it began where the
// system does not let a process forget that.
void reset_peak_memory();
double peak_memory_mib();

}  // namespace sightline
