/* Part of every program that is built with sanitizers: libraries stay loaded. The Vulkan loader unloads drivers before leaks and races
   are reported, and a report cannot name a library that is gone, nor a suppression match it. */
int dlclose(void* library);

__attribute__((visibility("default"))) int dlclose(void* library) {
  (void)library;
  return 0;
}
