// SPDX-License-Identifier: Apache-2.0
// Interface of the subcommands to CLI11. Only cli.cpp and command_line.cpp include the header of CLI11, which takes
// seconds to compile.
#pragma once
#include <functional>
#include <initializer_list>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace simplexseg {

/// Handle to an option, flag or positional argument. Each function sets a property and returns the handle.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option required() const;
  /// Sets the smallest and largest number of values.
  Option expected(int minimum, int maximum) const;
  /// Makes a list option take one value per use, so that positional arguments may follow it.
  Option one_value_each() const;
  Option one_of(std::initializer_list<const char*> values) const;
  /// Refuses an empty text, for example from an unset variable of a script.
  Option not_empty() const;
  Option within(int minimum, int maximum) const;
  Option within(double minimum, double maximum) const;
  Option excludes(Option other) const;
  /// Shows the current value of the variable as the default in the help.
  Option show_default() const;

 private:
  CLI::Option* option_;
};

/// Handle to a subcommand, or to the program itself.
class Subcommand {
 public:
  explicit Subcommand(CLI::App& app) : app_(&app) {}
  Subcommand add_subcommand(const std::string& name, const std::string& doc) const;
  /// Requires that exactly one of its subcommands is named.
  void require_subcommand() const;
  /// Adds an option. Parsing sets `value`, which must exist until parsing has ended. Defined for the types T that
  /// command_line.cpp lists.
  template <class T>
  Option add_option(const std::string& name, T& value, const std::string& doc) const;
  Option add_flag(const std::string& name, bool& value, const std::string& doc) const;
  /// Adds a flag that prints a text and ends the program with status 0.
  void add_print_flag(const std::string& name, std::function<std::string()> text, const std::string& doc) const;
  /// Sets the function that is called after parsing if this subcommand was named.
  void callback(std::function<void()> function) const;

 private:
  CLI::App* app_;
};

}  // namespace simplexseg
