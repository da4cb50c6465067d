// SPDX-License-Identifier: Apache-2.0
// Access to the values of a GDCM data set. GDCM has converted the numbers to the byte order of the machine.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
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

/// Exception for an element whose value violates the standard; the text names the element and its value, e.g. "its
/// Rescale Slope (0028,1053) is '0,5', which is not a number".
class InvalidElement : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Returns name and tag of an element for messages, e.g. "Rescale Slope (0028,1053)".
std::string element_name(DicomTag tag);
/// Throws InvalidElement for the element: "its NAME is 'VALUE', REASON".
[[noreturn]] void throw_invalid(const gdcm::DataSet& data, DicomTag tag, const std::string& reason);

/// Returns true when the data set contains the element.
bool has(const gdcm::DataSet& data, DicomTag tag);
/// Returns the text on one line, cut after `limit` bytes, see one_line(); empty when the element is missing.
std::string text_of(const gdcm::DataSet& data, DicomTag tag, std::size_t limit = 200);
/// Returns the bytes of a text without padding, in the character set of the file; empty when the element is missing.
std::string raw_text_of(const gdcm::DataSet& data, DicomTag tag);
/// Returns the numbers of an attribute; empty when the attribute is missing or empty. Throws InvalidElement unless the
/// whole value consists of finite numbers.
std::vector<double> numbers_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind = DicomKind::Text);
/// Returns the numbers of an attribute with `count` values; empty when the attribute is missing or empty. Throws
/// InvalidElement like numbers_of(), and for another number of values.
std::vector<double> numbers_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind, std::size_t count);
/// Returns the number of an attribute, the first of several binary ones; nullopt when there is none. Throws
/// InvalidElement like numbers_of(), and for several numbers as text.
std::optional<double> number_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind = DicomKind::Text);
/// Returns the first number of an attribute if it is an integer; nullopt when there is none. Throws InvalidElement like
/// numbers_of(), and for a fraction.
std::optional<double> integer_of(const gdcm::DataSet& data, DicomTag tag);
/// Returns the first unsigned 16-bit number of an attribute, or `otherwise` when there is none. Throws InvalidElement
/// like numbers_of().
int short_of(const gdcm::DataSet& data, DicomTag tag, int otherwise);

/// Calls f for each item of a sequence; does nothing when the sequence is missing.
void each_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f);
/// Calls f for the first item of a sequence; returns false when there is none.
bool first_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f);

}  // namespace simplexseg
