// SPDX-License-Identifier: Apache-2.0
// Fuzz targets: responses of archives (tests/archive/fuzz_seeds_test.cpp).
#pragma once
#include "archive/web_json.h"
#include "fuzz/target.h"

namespace simplexseg::test {

/// Reads a text as each of the responses of an archive over DICOMweb.
inline void fuzz_dicom_json(const std::filesystem::path& path) {
  const std::string text = small_file(path);
  ArchiveServer server;
  server.name = "test";
  if (text.starts_with('[') && text.ends_with(']')) store_response_of_json(text.substr(1, text.size() - 2));
  studies_of_json(server, text);
  series_of_json(server, text, "1.2.3");
  instances_of_json(server, text);
}

inline const FuzzTarget archive_fuzz_targets[] = {
    {"dicom_json", "fuzzed", fuzz_dicom_json},
    {"servers", "fuzzed.json", [](const std::filesystem::path& path) { read_archive_servers(path); }},
};

}  // namespace simplexseg::test
