// Preloaded into a program, makes every call of the kinds that SIGHTLINE_LACKS names ("fsync
// renameat2 flock thread") fail with the errno SIGHTLINE_LACKS_ERRNO, as where a file system or a
// container runtime does not support it.

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

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

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
