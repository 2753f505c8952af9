// Preloaded into a program, makes every call of the kinds that SIGHTLINE_LACKS names ("fsync
// renameat2 flock thread") fail with the errno SIGHTLINE_LACKS_ERRNO, as where a file system or a
// container runtime does not support it. "memory-of-zstd": libzstd gets no memory.

#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace {

bool lacks(const char* call) {
  const char* const names = std::getenv("SIGHTLINE_LACKS");
  return names != nullptr && std::strstr(names, call) != nullptr;
}

int number() {
  const char* const text = std::getenv("SIGHTLINE_LACKS_ERRNO");
  return text != nullptr ? std::atoi(text) : ENOSYS;
}

int failure() {
  errno = number();
  return -1;
}

// Of the function that calls: whether it is libzstd's.
bool is_of_zstd(const void* caller) {
  Dl_info info{};
  return ::dladdr(caller, &info) != 0 && info.dli_fname != nullptr &&
         std::strstr(info.dli_fname, "libzstd") != nullptr;
}

bool has_no_memory(const void* caller) { return lacks("memory-of-zstd") && is_of_zstd(caller); }

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

// glibc's own names: dlsym itself takes memory.
void* __libc_malloc(std::size_t size);                     // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t count, std::size_t size);  // NOLINT(bugprone-reserved-identifier)

void* malloc(std::size_t size) noexcept {
  return has_no_memory(__builtin_return_address(0)) ? nullptr : __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  return has_no_memory(__builtin_return_address(0)) ? nullptr : __libc_calloc(count, size);
}

int fsync(int file) { return lacks("fsync") ? failure() : real<int (*)(int)>("fsync")(file); }

int flock(int file, int operation) noexcept {
  return lacks("flock") ? failure() : real<int (*)(int, int)>("flock")(file, operation);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to,
              unsigned flags) noexcept {
  if (lacks("renameat2")) return failure();
  return real<int (*)(int, const char*, int, const char*, unsigned)>("renameat2")(
      from_folder, from, to_folder, to, flags);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*),
                   void* argument) noexcept {
  if (lacks("thread")) return number();
  return real<int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>(
      "pthread_create")(thread, attributes, body, argument);
}

}  // extern "C"
