// SPDX-License-Identifier: Apache-2.0
// Interface of the subcommands to CLI11. Only one source includes the header of CLI11, which takes seconds to compile.
#pragma once
#include <functional>
#include <initializer_list>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace simplexseg {

/// Handle to an option, flag or positional argument. Each function adds a property and returns the handle.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option required() const;
  /// Sets the number of positional arguments.
  Option expected(int minimum, int maximum) const;
  /// Makes a list option take one value per use, so that positional arguments may follow it.
  Option one_value_each() const;
  Option one_of(std::initializer_list<const char*> values) const;
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
  /// Makes one of its subcommands mandatory.
  void require_subcommand() const;
  /// Adds an option. Parsing sets `value`, which must exist until then. Defined for the types of T that are listed in
  /// command_line.cpp.
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
