#include <fcntl.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "compiler/cli/command_line.h"
#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "compiler/pipeline/process_cost.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/files/file_system_gap.h"

namespace sightline {
namespace {

// Written where nothing can be allocated any more, or in a signal handler.
void say(std::string_view text) { (void)!::write(STDERR_FILENO, text.data(), text.size()); }

constexpr std::string_view kOutOfMemory =
    "SL8005 out-of-memory: not enough memory; fewer threads or shorter drives take less\n";
constexpr std::string_view kNoThread =
    "SL8005 out-of-memory: the system starts no further thread (a limit of processes, or an old "
    "container runtime); --threads 1 needs none\n";
constexpr std::string_view kShrank =
    "SL8002 cannot-read: a file became shorter while it was read\n";

[[noreturn]] void leave(std::string_view text, ErrorCode code) {
  say(text);
  ::_exit(exit_status(code));
}

struct Meaning {
  ErrorCode code{};
  std::string_view text = {};
};
constexpr Meaning kMemory{ErrorCode::kOutOfMemory, kOutOfMemory};
constexpr Meaning kThread{ErrorCode::kOutOfMemory, kNoThread};

// What an exception of the standard library means, if it is none of our own mistakes. A length that
// no vector can have is a request for memory as well.
std::optional<Meaning> meaning_of(const std::exception_ptr& exception) {
  if (!exception) return {};
  try {
    std::rethrow_exception(exception);
  } catch (const std::bad_alloc&) {
    return kMemory;
  } catch (const std::length_error&) {
    return kMemory;
  } catch (const std::filesystem::filesystem_error&) {
    return Meaning{ErrorCode::kCannotRead};
  } catch (const std::system_error& error) {
    const int number = error.code().value();
    if (number == ENOMEM) return kMemory;
    if (number == EAGAIN || number == EPERM) return kThread;
    return {};
  } catch (const std::runtime_error& error) {
    // What oneTBB throws on a thread of its own that can have no further one.
    if (std::string_view(error.what()).starts_with("pthread_create")) return kThread;
    return {};
  } catch (...) {
    return {};
  }
}

std::terminate_handler usual_terminate = std::abort;

// An exception on a thread of a library, or out of a function that must not throw.
[[noreturn]] void on_terminate() {
  const std::optional<Meaning> meaning = meaning_of(std::current_exception());
  if (meaning && !meaning->text.empty()) leave(meaning->text, meaning->code);
  usual_terminate();  // says what it was, and aborts
  std::abort();
}

void on_bus_error(int /*signal*/) { leave(kShrank, ErrorCode::kCannotRead); }

int report_exception() {
  const std::exception_ptr exception = std::current_exception();
  const std::optional<Meaning> meaning = meaning_of(exception);
  if (!meaning) std::rethrow_exception(exception);
  if (!meaning->text.empty()) {
    say(meaning->text);
    return exit_status(meaning->code);
  }
  try {
    std::rethrow_exception(exception);
  } catch (const std::filesystem::filesystem_error& error) {
    return report_error({meaning->code, error.code().message(), error.path1().string()});
  }
}

// A file that is opened while one of the standard descriptors is closed would get its number, and
// what is printed would go into it.
void open_standard_descriptors() {
  for (int descriptor = 0; descriptor <= STDERR_FILENO; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) >= 0) continue;
    // The lowest free number is this one. Where there is no /dev/null, a folder holds it.
    if (::open("/dev/null", O_RDWR) < 0) (void)::open("/", O_RDONLY);
  }
}

// What is printed may be data: it must not end early and be called whole.
int finish_output(int status) {
  errno = 0;
  const bool is_flushed = std::fflush(stdout) == 0;
  if (is_flushed && std::ferror(stdout) == 0) return status;
  // Nothing may be left of the reason where an earlier write was the one that failed.
  const Error error = errno != 0
                          ? write_failure("stdout", "cannot write", errno)
                          : Error{ErrorCode::kCannotWrite, "not all could be written", "stdout"};
  const int failed = report_error(error);
  return status == 0 ? failed : status;
}

// Runs the program's body, and turns what no function can return into failures with a code:
// memory that is not there, on any thread and out of any library (out-of-memory); threads that
// cannot be had (likewise); a mapped file that became shorter (cannot-read); output that does not
// fit behind stdout (disk-full, cannot-write). A limit on the size of files ends no process from
// here on, writing fails instead. Returns the exit status. Our own mistakes still abort.
int run_guarded(const std::function<int()>& body) {
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGBUS, on_bus_error);
  usual_terminate = std::set_terminate(on_terminate);
  int status = 0;
  try {
    status = body();
  } catch (...) {
    status = report_exception();
  }
  return finish_output(status);
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  sightline::open_standard_descriptors();
  sightline::return_freed_memory();
  sightline::receive_gaps(sightline::print_warning);
  return sightline::run_guarded([&] {
    return sightline::run_command_line(sightline::sightline_program(), {argv + 1, argv + argc});
  });
}
