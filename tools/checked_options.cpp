#include "tools/checked_options.h"

#include <algorithm>
#include <string_view>

namespace nephele::tools {
namespace {

// Where the placeholder names every value there is nothing to add to the help.
std::string help_text(const std::string& help, const std::string& unit, const Accepted& accepted) {
  if (std::holds_alternative<Toggle>(accepted) || std::holds_alternative<OneOfNames>(accepted) ||
      std::holds_alternative<OneOfNumbers>(accepted))
    return help;
  return help + " (" + (unit.empty() ? "" : unit + ": ") + accepted_words(accepted) + ")";
}

// The help is shown as it stands.
CLI::Option* add_option(CLI::App& app, const std::string& name, const std::string& help, const Accepted& accepted,
                        const std::string& shown_default, std::function<void(const Value&)> take) {
  const auto read = [name, accepted, take = std::move(take)](const std::string& text) {
    const std::optional<Value> value = read_value(accepted, text);
    if (!value) throw CLI::ValidationError(not_accepted(name, shown_text(text), accepted).message);
    take(*value);
  };
  CLI::Option* option = app.add_option_function<std::string>(name, read, help)->type_name(placeholder(accepted));
  // A toggle's name alone turns it on: an option that expects nothing has the value "true", and may still be given one.
  if (std::holds_alternative<Toggle>(accepted)) option->expected(0)->expected(0, 1);
  if (!shown_default.empty()) option->default_str(shown_default);
  return option;
}

}  // namespace

CLI::Option* add_checked_option(CLI::App& app, const std::string& name, const std::string& help,
                                const Accepted& accepted, const std::string& shown_default,
                                std::function<void(const Value&)> take) {
  return add_option(app, name, help_text(help, "", accepted), accepted, shown_default, std::move(take));
}

bool TypedSettings::has(const char* key) const {
  return std::any_of(given.begin(), given.end(),
                     [&](const Setting* setting) { return std::string_view(setting->key) == key; });
}

void add_setting_options(CLI::App& app, TypedSettings& typed) {
  for (const Setting& setting : all_settings()) {
    const auto take = [&typed, &setting](const Value& value) {
      setting.set(typed.settings, value);
      typed.given.push_back(&setting);
    };
    add_option(app, setting.option, help_text(setting.help, setting.unit, setting.accepted), setting.accepted,
               value_text(setting.get(typed.settings)), take)
        ->group("Settings");
  }
}

std::optional<Error> find_empty_value(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& value : option->results())
      if (value.empty()) return Error{option->get_name() + " is empty; accepted: " + option->get_type_name()};
  return std::nullopt;
}

}  // namespace nephele::tools
