// SPDX-License-Identifier: Apache-2.0
// Programs of SimplexSeg that serve requests of the other programs as worker processes (worker_process.h).
#pragma once
#include <filesystem>

namespace simplexseg {

/// Name and messages of a worker program. Objects are constants, compared by address.
struct WorkerProgram {
  const char* name;        ///< file name
  const char* variable;    ///< environment variable with the path, for tests and unusual installations
  const char* purpose;     ///< for messages: "which reads DICOM and MINC"
  const char* activity;    ///< for messages: "read", followed by a file
  const char* process;     ///< for messages: "the process that reads it"
  const char* remedy;      ///< when it is missing or lacks a library
  const char* crash;       ///< reason of a failure when a library crashed or threw an unknown exception
  const char* time_limit;  ///< reason of a failure when the limit of processor time is exceeded
};

/// Program that reads DICOM and MINC.
inline constexpr WorkerProgram kReaderProgram{.name = "simplexseg-reader",
                                              .variable = "SIMPLEXSEG_READER",
                                              .purpose = "which reads DICOM and MINC",
                                              .activity = "read",
                                              .process = "the process that reads it",
                                              .remedy = "install SimplexSeg again",
                                              .crash = "it is damaged (the library that reads it failed)",
                                              .time_limit = "it is damaged (reading it exceeds the limit of time)"};

/// Program that registers and filters images by ITK (docs/adr/0058-registration.md).
inline constexpr WorkerProgram kRegisterProgram{
    .name = "simplexseg-register",
    .variable = "SIMPLEXSEG_REGISTER",
    .purpose = "which registers and filters images by ITK",
    .activity = "process",
    .process = "the process that computes",
    .remedy = "install ITK 5 (package libinsighttoolkit5-dev) and build SimplexSeg again",
    .crash = "the process that computes failed",
    .time_limit = "the limit of time is exceeded"};

/// Returns the path of a worker program: the value of its environment variable if it is set, otherwise the first that
/// exists: beside the running program, beside the shared object that contains this function (the Python module), in
/// ../libexec/simplexseg beside the folder of the running program, and in the folder of the installation. Throws Error
/// when there is none.
std::filesystem::path path_of_program(const WorkerProgram& program);

}  // namespace simplexseg
