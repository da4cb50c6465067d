// SPDX-License-Identifier: Apache-2.0
// What subcommands say about their options. It stands before CLI11, whose header takes seconds to compile, so that one
// source alone includes it.
#pragma once
#include <functional>
#include <initializer_list>
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace simplexseg {

/// One option, flag or positional argument; a handle to it. Each function adds a condition and gives the handle back.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option required() const;
  /// Positional arguments: how many.
  Option expected(int least, int most) const;
  /// An option that takes a list: one value each time that it is named, so that positional arguments may follow it.
  Option one_value_each() const;
  Option one_of(std::initializer_list<const char*> values) const;
  Option within(int least, int most) const;
  Option within(double least, double most) const;
  Option excludes(Option other) const;
  /// The help shows the value that the variable has now.
  Option show_default() const;

 private:
  CLI::Option* option_;
};

/// A subcommand, or the program itself; a handle to it.
class Subcommand {
 public:
  explicit Subcommand(CLI::App& app) : app_(&app) {}
  Subcommand add_subcommand(const std::string& name, const std::string& doc) const;
  /// It is nothing without one of the subcommands that are added to it.
  void require_subcommand() const;
  /// `value` is set while the command line is parsed; it must live until then. For the types of T that
  /// command_line.cpp names.
  template <class T>
  Option add_option(const std::string& name, T& value, const std::string& doc) const;
  Option add_flag(const std::string& name, bool& value, const std::string& doc) const;
  /// A flag that prints a text, and nothing else is done or asked for.
  void add_answer(const std::string& name, std::function<std::string()> text, const std::string& doc) const;
  /// Called, once everything is parsed, where this subcommand was named.
  void callback(std::function<void()> function) const;

 private:
  CLI::App* app_;
};

}  // namespace simplexseg
