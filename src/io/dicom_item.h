// SPDX-License-Identifier: Apache-2.0
// DICOM data sets that are made here, and the files that hold them; dicom_values.h reads such.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/dicom_values.h"

namespace simplexseg {

class AtomicFile;

/// Explicit: each element says how its value is kept, but texts have 65534 bytes at most; implicit ones may be longer.
enum class DicomCoding { Explicit, Implicit };

/// A data set, or an item of a sequence. Elements may come in any order; one that comes again replaces the former. How
/// a value is kept (its VR) is as GDCM's dictionary of the standard says.
class DicomItem {
 public:
  DicomItem();
  DicomItem(const DicomItem&) = delete;
  DicomItem& operator=(const DicomItem&) = delete;
  DicomItem(DicomItem&&) noexcept;
  DicomItem& operator=(DicomItem&&) noexcept;
  ~DicomItem();

  /// Values of several parts have them separated by a backslash. Empty: the element without a value.
  DicomItem& text(DicomTag tag, const std::string& value);
  DicomItem& shorts(DicomTag tag, std::span<const std::uint16_t> values);
  DicomItem& longs(DicomTag tag, std::span<const std::uint32_t> values);
  /// The tag of another element.
  DicomItem& pointer(DicomTag tag, DicomTag to);
  /// As text (DS), each in 16 characters at most: to at least ten digits.
  DicomItem& numbers(DicomTag tag, std::span<const double> values);
  DicomItem& bytes(DicomTag tag, const std::vector<std::uint8_t>& values);
  DicomItem& items(DicomTag tag, std::span<const DicomItem> items);
  /// A sequence of one item.
  DicomItem& item(DicomTag tag, const DicomItem& one);
  /// A sequence of one code (PS3.3 8.8).
  DicomItem& code(DicomTag tag, const std::string& value, const std::string& scheme, const std::string& meaning);
  DicomItem& remove(DicomTag tag);
  /// A text of another data set, to the byte; false where it has none or an empty one.
  bool take(const gdcm::DataSet& from, DicomTag tag);

 private:
  void put(DicomTag tag, const void* bytes, std::size_t count);

  std::unique_ptr<gdcm::DataSet> data_;

  friend void write_dicom(AtomicFile& file, const DicomItem& data, DicomCoding coding);
};

/// The shortest text of at most 16 characters that says the number, as DS allows.
std::string decimal_string(double value);

/// A name that is in no other file.
std::string new_dicom_uid();

/// Writes a file of little endian byte order with its preamble and meta information; `data` names its SOP class and
/// instance. Throws Error when it cannot be written.
void write_dicom(AtomicFile& file, const DicomItem& data, DicomCoding coding);

}  // namespace simplexseg
