// Options whose values are checked against what is accepted (engine/accepted.h): their help and their error lines are
// in that table's words, on every version of the command line library.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/accepted.h"
#include "engine/check.h"
#include "passes/settings.h"

namespace nephele::tools {

// Calls take(value) for an accepted value; any other ends parsing with one line. shown_default: "" shows none.
CLI::Option* add_checked_option(CLI::App& app, const std::string& name, const std::string& help,
                                const Accepted& accepted, const std::string& shown_default,
                                std::function<void(const Value&)> take);

namespace detail {

template <class T>
struct Unwrapped {
  using Type = T;
};
template <class T>
struct Unwrapped<std::optional<T>> {
  using Type = T;
};

// The alternative of Value that holds a T.
template <class T>
using Held = std::conditional_t<std::is_unsigned_v<T>, std::uint64_t, T>;

template <class T>
std::string shown_default(const T& value) {
  return value_text(Value(static_cast<Held<T>>(value)));
}
template <class T>
std::string shown_default(const std::optional<T>& value) {
  return value ? shown_default(*value) : "";
}

}  // namespace detail

// Stores the value in `target`: an unsigned number, a double, a text, or an optional of one of them. What `target`
// holds is shown as the default.
template <class T>
CLI::Option* add_checked_option(CLI::App& app, const std::string& name, T& target, const std::string& help,
                                const Accepted& accepted) {
  using Type = typename detail::Unwrapped<T>::Type;
  return add_checked_option(app, name, help, accepted, detail::shown_default(target), [&target](const Value& value) {
    target = static_cast<Type>(std::get<detail::Held<Type>>(value));
  });
}

// What was typed for the settings.
struct TypedSettings {
  RenderSettings settings;  // before parsing: the command's defaults
  std::vector<const Setting*> given;

  bool has(const char* key) const;
};

// An option for every setting of the table.
void add_setting_options(CLI::App& app, TypedSettings& typed);

// The first option that was given an empty value.
std::optional<Error> find_empty_value(const CLI::App& app);

}  // namespace nephele::tools
