#pragma once

namespace sightline {

// CPU time of this process so far, all threads, user and system.
double process_cpu_s();

// The largest memory that this process had since reset_peak_memory(), which gives what was freed
// back to the system; since it began where the system does not let a process forget that.
void reset_peak_memory();
double peak_memory_mib();

// From here on large blocks go back to the system when they are freed. The allocator of glibc would
// keep them once some have come and gone: half of what a trajectory of 2.4 km takes. Once, before
// there are threads.
void return_freed_memory();

}  // namespace sightline
