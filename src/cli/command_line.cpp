// SPDX-License-Identifier: Apache-2.0
#include "cli/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "core/number_text.h"

namespace simplexseg {

Option Option::required() const { return Option(option_->required()); }
Option Option::expected(int minimum, int maximum) const { return Option(option_->expected(minimum, maximum)); }
Option Option::one_value_each() const { return Option(option_->allow_extra_args(false)); }
Option Option::one_of(std::initializer_list<const char*> values) const {
  return Option(option_->check(CLI::IsMember(std::vector<std::string>(values.begin(), values.end()))));
}
Option Option::not_empty() const {
  const auto message = [](const std::string& value) {
    return value.empty() ? std::string("the value is empty; name a file or folder, or omit it") : std::string();
  };
  return Option(option_->check(message, ""));
}
Option Option::within(int minimum, int maximum) const { return Option(option_->check(CLI::Range(minimum, maximum))); }
Option Option::within(double minimum, double maximum) const {
  return Option(option_->check(CLI::Range(minimum, maximum)));
}
Option Option::excludes(Option other) const { return Option(option_->excludes(other.option_)); }
Option Option::show_default() const { return Option(option_->capture_default_str()); }

Subcommand Subcommand::add_subcommand(const std::string& name, const std::string& doc) const {
  return Subcommand(*app_->add_subcommand(name, doc));
}
void Subcommand::require_subcommand() const { app_->require_subcommand(1); }

template <class T>
Option Subcommand::add_option(const std::string& name, T& value, const std::string& doc) const {
  CLI::Option* const option = app_->add_option(name, value, doc);
  if constexpr (std::is_same_v<T, int> || std::is_same_v<T, std::optional<int>> || std::is_same_v<T, std::uint64_t>) {
    option->transform([](const std::string& text) {  // CLI11 reads numbers with a leading 0 as octal
      const std::optional<std::int64_t> number = parse_integer(text);
      return number ? std::to_string(*number) : text;
    });
  }
  return Option(option);
}
template Option Subcommand::add_option(const std::string&, std::string&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, int&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::optional<int>&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, double&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<double>&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::optional<double>&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::uint64_t&, const std::string&) const;

Option Subcommand::add_flag(const std::string& name, bool& value, const std::string& doc) const {
  return Option(app_->add_flag(name, value, doc));
}
void Subcommand::add_print_flag(const std::string& name, std::function<std::string()> text,
                                const std::string& doc) const {
  app_->add_flag_callback(
      name, [text = std::move(text)] { throw CLI::CallForVersion(text(), 0); }, doc);
}
void Subcommand::callback(std::function<void()> function) const { app_->callback(std::move(function)); }

}  // namespace simplexseg
