// SPDX-License-Identifier: Apache-2.0
// Creation of DICOM data sets and files; dicom_values.h reads them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/dicom/dicom_values.h"

namespace simplexseg {

class AtomicFile;

/// Location of the value representations. Explicit: in each element of the file; a text then has at most 65534 bytes.
/// Implicit: in the dictionary of the standard; longer texts are possible.
enum class DicomCoding { Explicit, Implicit };

/// Data set, or item of a sequence. Elements can be added in any order; an element with the same tag is replaced. The
/// value representation (VR) of each element comes from GDCM's dictionary.
class DicomItem {
 public:
  DicomItem();
  DicomItem(const DicomItem&) = delete;
  DicomItem& operator=(const DicomItem&) = delete;
  DicomItem(DicomItem&&) noexcept;
  DicomItem& operator=(DicomItem&&) noexcept;
  ~DicomItem();

  /// Adds a text in which backslashes separate several values. An empty text adds the element without a value.
  DicomItem& text(DicomTag tag, const std::string& value);
  DicomItem& shorts(DicomTag tag, std::span<const std::uint16_t> values);
  DicomItem& longs(DicomTag tag, std::span<const std::uint32_t> values);
  /// Adds an element whose value is the tag `to` of another element (VR AT).
  DicomItem& pointer(DicomTag tag, DicomTag to);
  /// Adds decimal strings (VR DS), see decimal_string().
  DicomItem& numbers(DicomTag tag, std::span<const double> values);
  /// Adds an even number of bytes.
  DicomItem& bytes(DicomTag tag, const std::vector<std::uint8_t>& values);
  /// Adds words as pixels of 16 bits (VR OW).
  DicomItem& words(DicomTag tag, std::span<const std::uint16_t> values);
  /// Adds a sequence.
  DicomItem& items(DicomTag tag, std::span<const DicomItem> items);
  /// Adds a sequence with one item.
  DicomItem& item(DicomTag tag, const DicomItem& one);
  /// Adds a sequence with one code (PS3.3 8.8).
  DicomItem& code(DicomTag tag, const std::string& value, const std::string& scheme, const std::string& meaning);
  /// Removes the element, if it exists.
  DicomItem& remove(DicomTag tag);

 private:
  void set_value(DicomTag tag, const void* bytes, std::size_t count);

  std::unique_ptr<gdcm::DataSet> data_;

  friend std::string dicom_bytes(const DicomItem& data);
  friend void write_dicom(AtomicFile& file, const DicomItem& data, DicomCoding coding);
};

/// Returns the number as decimal string (DS) of at most 16 characters: the shortest exact text if it fits, otherwise a
/// text rounded to at least ten significant digits (nine if the exponent has three digits).
std::string decimal_string(double value);

/// Returns a new unique identifier (UID).
std::string new_dicom_uid();

/// Data set in Explicit VR Little Endian, without preamble and meta information.
std::string dicom_bytes(const DicomItem& data);

/// Writes a little-endian DICOM file with preamble and meta information. `data` must contain the SOP class UID and the
/// SOP instance UID. Throws Error when the file cannot be written.
void write_dicom(AtomicFile& file, const DicomItem& data, DicomCoding coding);

}  // namespace simplexseg
