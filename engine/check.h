// Always-on assertions for programming and Vulkan failures: print the expression, the values and the
// place, then abort. Never for user input (that is a Result, see result.h).
#pragma once

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>

namespace nephele {

[[noreturn]] inline void check_failed(const char* file, int line, const char* expression, const std::string& detail) {
  std::fprintf(stderr, "%s:%d: check failed: %s%s%s\n", file, line, expression, detail.empty() ? "" : ": ",
               detail.c_str());
  std::abort();
}

template <class... Parts>
std::string concat(const Parts&... parts) {
  std::ostringstream text;
  static_cast<void>((text << ... << parts));  // no parts: no effect
  return text.str();
}

}  // namespace nephele

// NEPHELE_CHECK(condition, parts...): the parts are streamed into the message.
#define NEPHELE_CHECK(condition, ...)                                                                          \
  do {                                                                                                         \
    if (!(condition)) ::nephele::check_failed(__FILE__, __LINE__, #condition, ::nephele::concat(__VA_ARGS__)); \
  } while (false)

// NEPHELE_VK(call): a Vulkan call that must succeed.
#define NEPHELE_VK(call)                                                                            \
  do {                                                                                              \
    const VkResult nephele_vk_result = (call);                                                      \
    if (nephele_vk_result != VK_SUCCESS)                                                            \
      ::nephele::check_failed(__FILE__, __LINE__, #call,                                            \
                              ::nephele::concat("VkResult ", static_cast<int>(nephele_vk_result))); \
  } while (false)
