// SPDX-License-Identifier: Apache-2.0
// Values of a data set of GDCM's, which has put numbers into the machine's byte order.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace gdcm {
class DataSet;
}

namespace simplexseg {

struct DicomTag {
  std::uint16_t group, element;
};

/// How a value is kept in the file: as text, or as numbers of 2, 4 or 8 bytes (US, UL, FD).
enum class DicomKind { Text, Short, Long, Double };

bool has(const gdcm::DataSet& data, DicomTag tag);
/// One line; empty where there is none.
std::string text_of(const gdcm::DataSet& data, DicomTag tag, std::size_t limit = 200);
/// The bytes of a text without the blanks that fill it up; in the file's own coding.
std::string raw_text_of(const gdcm::DataSet& data, DicomTag tag);
/// All numbers of an attribute, up to the first that is no finite number.
std::vector<double> numbers_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind = DicomKind::Text);
/// The first of them.
std::optional<double> number_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind = DicomKind::Text);
int short_of(const gdcm::DataSet& data, DicomTag tag, int otherwise);

/// Calls f for each item of a sequence; where there is none, for none.
void each_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f);
/// Calls f for the first item; false where there is none.
bool first_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f);

}  // namespace simplexseg
