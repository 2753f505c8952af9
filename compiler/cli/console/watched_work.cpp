#include "compiler/cli/console/watched_work.h"

#include <chrono>

#include "compiler/cli/console/console.h"
#include "formats/base/stopwatch.h"

namespace sightline {

Result<void> do_watched(const WatchedWork& work,
                        const std::function<Result<void>(PassContext& ctx)>& body) {
  const bool is_json = work.json_progress != 0;
  if (is_json) SIGHTLINE_TRY(check_progress_descriptor(work.json_progress));
  const RunObserver observer =
      is_json ? json_observer(work.json_progress) : console_observer(verbosity());
  PassContext ctx;
  ctx.threads = work.threads;
  ctx.progress_sink = observer.progress;
  ctx.warning_sink = [&](const std::string& message) { observer.warning(work.name, message); };
  observer.started(0, 1, work.name);
  for (const std::string& warning : work.warnings) ctx.warn(warning);
  const auto begin = std::chrono::steady_clock::now();
  const double begin_ms = thread_cpu_ms();
  SIGHTLINE_TRY(body(ctx));
  StepReport report;
  report.name = work.name;
  report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.cpu_s = (thread_cpu_ms() - begin_ms) / 1e3;
  observer.finished(report);
  return {};
}

}  // namespace sightline
