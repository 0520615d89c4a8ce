// For sanitizer builds, included once per program (in its main.cpp). Vulkan drivers and layers keep memory that they
// never free, which is theirs; ours must stay visible to the leak checker. It tells them apart by module, so modules
// stay loaded until the end, and the drivers' are left out.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
extern "C" {
// Replaces the C library's: the Vulkan loader unloads drivers before leaks are looked for.
int dlclose(void*) { return 0; }

const char* __lsan_default_options() { return "print_suppressions=0"; }

const char* __lsan_default_suppressions() {
  return "leak:libvulkan_\n"
         "leak:libVkLayer_\n"
         "leak:libLLVM\n";
}
}
#endif
