// SPDX-License-Identifier: Apache-2.0
// Access to the values of a GDCM data set. GDCM has converted the numbers to the byte order of the machine.
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

/// Encoding of numbers: text (DS, IS), or binary with 2, 4 or 8 bytes (US, UL, FD).
enum class DicomKind { Text, Short, Long, Double };

/// Returns true when the data set contains the element.
bool has(const gdcm::DataSet& data, DicomTag tag);
/// Returns the text on one line, cut after `limit` bytes, see one_line(); empty when the element is missing.
std::string text_of(const gdcm::DataSet& data, DicomTag tag, std::size_t limit = 200);
/// Returns the bytes of a text without padding, in the character set of the file; empty when the element is missing.
std::string raw_text_of(const gdcm::DataSet& data, DicomTag tag);
/// Returns the numbers of an attribute up to the first invalid or non-finite one; empty when the attribute is missing.
std::vector<double> numbers_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind = DicomKind::Text);
/// Returns the first number of an attribute; nullopt when there is none.
std::optional<double> number_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind = DicomKind::Text);
/// Returns the first unsigned 16-bit number of an attribute, or `otherwise` when there is none.
int short_of(const gdcm::DataSet& data, DicomTag tag, int otherwise);

/// Calls f for each item of a sequence; does nothing when the sequence is missing.
void each_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f);
/// Calls f for the first item of a sequence; returns false when there is none.
bool first_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f);

}  // namespace simplexseg
