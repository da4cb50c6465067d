// SPDX-License-Identifier: Apache-2.0
#include "python/messages.h"

#include <filesystem>

#include "app/console.h"
#include "core/system_error.h"
#include "io/platform/files.h"
#include "python/bindings.h"

namespace simplexseg::python {
namespace {

// Exception types of the module, which is loaded at most once and never unloaded.
PyObject *error_type = nullptr, *simulation_error_type = nullptr, *warning_type = nullptr;

constexpr std::size_t kMaxLineLength = 2000;

PyObject* new_type(py::module_& module, const char* name, const char* doc, PyObject* base) {
  const std::string whole = std::string("simplexseg.") + name;
  PyObject* const type = PyErr_NewExceptionWithDoc(whole.c_str(), doc, base, nullptr);
  if (!type) throw py::error_already_set();
  module.attr(name) = py::handle(type);
  return type;
}

void raise(PyObject* type, const std::exception& exception) {
  PyErr_SetObject(type, python_text(one_line(exception.what(), kMaxLineLength)).ptr());
}

}  // namespace

py::str python_text(const std::string& text) {
  PyObject* const decoded = PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace");
  if (!decoded) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

py::list python_texts(const std::vector<std::string>& texts) {
  py::list list;
  for (const std::string& text : texts) list.append(python_text(text));
  return list;
}

void warn(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    const std::string text = python_text(one_line(line, kMaxLineLength));
    if (PyErr_WarnEx(warning_type, text.c_str(), 1) != 0) throw py::error_already_set();
  }
}

void check_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void bind_messages(py::module_& module) {
  error_type = new_type(module, "Error",
                        "Invalid input or a failed resource. The message is one line: what happened, why, what to do.",
                        PyExc_RuntimeError);
  simulation_error_type =
      new_type(module, "SimulationError",
               "Failure of a step at every timestep. The message names the mesh and the force. The session "
               "keeps the pose before the step and can continue.",
               error_type);
  warning_type =
      new_type(module, "DataWarning",
               "Assumption or omission of a reader, or a problem of a segmentation, in one line.", PyExc_UserWarning);
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(std::move(pointer));
    } catch (const SimulationError& error) {
      raise(simulation_error_type, error);
    } catch (const Error& error) {
      raise(error_type, error);
    } catch (const Failure& failure) {
      raise(error_type, failure);
    } catch (const std::filesystem::filesystem_error& error) {
      raise(error_type, Error("file system", system_error_text(error.code()), "check the path"));
    }
  });
}

}  // namespace simplexseg::python
