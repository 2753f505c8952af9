// Preloaded into a program, makes one call that changes a disk fail: the one numbered
// SIGHTLINE_FAIL_AT, counted from 0, with the errno SIGHTLINE_FAIL_ERRNO. Where
// SIGHTLINE_FAIL_DONE is set the call is carried out all the same and says that it failed, as a
// file system on a network may. When the program ends, SIGHTLINE_FAIL_COUNT gets a byte for each
// call.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>

namespace {

std::atomic<long> calls = 0;

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
}

// Counts the call. Whether it is the one to fail.
bool fails() {
  static const char* const at = std::getenv("SIGHTLINE_FAIL_AT");
  const long number = calls++;
  return at != nullptr && std::atol(at) == number;
}

int failure() {
  const char* const number = std::getenv("SIGHTLINE_FAIL_ERRNO");
  errno = number != nullptr ? std::atoi(number) : EIO;
  return -1;
}

template <class Call>
auto unless_it_fails(const Call& call) -> decltype(call()) {
  if (!fails()) return call();
  if (std::getenv("SIGHTLINE_FAIL_DONE") != nullptr) (void)call();
  return failure();
}

// Standard streams are not what is meant.
bool is_file(int descriptor) {
  struct stat status {};
  return descriptor > 2 && ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

struct Counter {
  ~Counter() {
    const char* const path = std::getenv("SIGHTLINE_FAIL_COUNT");
    if (path == nullptr) return;
    if (FILE* const file = std::fopen(path, "w")) {
      std::fprintf(file, "%ld\n", calls.load());
      std::fclose(file);
    }
  }
} counter;

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  const auto call = [&] { return real<int (*)(const char*, int, ...)>("open")(path, flags, mode); };
  return (flags & O_CREAT) == 0 ? call() : fails() ? failure() : call();
}
ssize_t write(int file, const void* data, std::size_t size) {
  const auto call = [&]() -> ssize_t {
    return real<ssize_t (*)(int, const void*, std::size_t)>("write")(file, data, size);
  };
  return is_file(file) ? unless_it_fails(call) : call();
}
ssize_t pwrite(int file, const void* data, std::size_t size, off_t offset) {
  return unless_it_fails([&]() -> ssize_t {
    return real<ssize_t (*)(int, const void*, std::size_t, off_t)>("pwrite")(file, data, size,
                                                                             offset);
  });
}
int ftruncate(int file, off_t size) noexcept {
  return unless_it_fails([&] { return real<int (*)(int, off_t)>("ftruncate")(file, size); });
}
int fsync(int file) {
  return unless_it_fails([&] { return real<int (*)(int)>("fsync")(file); });
}
int rename(const char* from, const char* to) noexcept {
  return unless_it_fails(
      [&] { return real<int (*)(const char*, const char*)>("rename")(from, to); });
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to,
              unsigned flags) noexcept {
  return unless_it_fails([&] {
    return real<int (*)(int, const char*, int, const char*, unsigned)>("renameat2")(
        from_folder, from, to_folder, to, flags);
  });
}
int link(const char* from, const char* to) noexcept {
  return unless_it_fails([&] { return real<int (*)(const char*, const char*)>("link")(from, to); });
}
int unlink(const char* path) noexcept {
  return unless_it_fails([&] { return real<int (*)(const char*)>("unlink")(path); });
}

}  // extern "C"
