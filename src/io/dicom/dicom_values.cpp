// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_values.h"

#include <gdcmDataSet.h>
#include <gdcmDict.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/number_text.h"
#include "io/dicom/gdcm_tag.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

const gdcm::ByteValue* bytes_of(const gdcm::DataSet& data, DicomTag tag) {
  if (!data.FindDataElement(tag_of(tag))) return nullptr;
  return data.GetDataElement(tag_of(tag)).GetByteValue();
}

template <class T>
std::vector<double> binary_numbers(DicomTag tag, const gdcm::ByteValue& value) {
  if (value.GetLength() % sizeof(T) != 0)
    throw InvalidElement("its " + element_name(tag) + " has " + std::to_string(value.GetLength()) +
                         " bytes, which is no multiple of " + std::to_string(sizeof(T)));
  std::vector<double> numbers;
  for (std::size_t at = 0; at < value.GetLength(); at += sizeof(T)) {
    T number;
    std::memcpy(&number, value.GetPointer() + at, sizeof number);
    if (!std::isfinite(static_cast<double>(number)))
      throw InvalidElement("its " + element_name(tag) + " is not finite");
    numbers.push_back(static_cast<double>(number));
  }
  return numbers;
}

std::vector<double> text_numbers(const gdcm::DataSet& data, DicomTag tag, const gdcm::ByteValue& value) {
  constexpr std::string_view kPadding(" \0", 2);
  std::vector<double> numbers;
  const std::string_view text(value.GetPointer(), value.GetLength());
  if (text.find_first_not_of(kPadding) == std::string_view::npos) return numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find('\\', at), text.size());
    const std::optional<double> number = parse_number(text.substr(at, end - at));
    const bool is_single = numbers.empty() && end == text.size();
    if (!number)
      throw_invalid(data, tag, is_single ? "which is not a number" : "which contains a value that is not a number");
    numbers.push_back(*number);
    at = end + 1;
  }
  return numbers;
}

gdcm::SmartPointer<gdcm::SequenceOfItems> items_of(const gdcm::DataSet& data, DicomTag sequence) {
  if (!data.FindDataElement(tag_of(sequence))) return nullptr;
  const gdcm::DataElement& element = data.GetDataElement(tag_of(sequence));
  return element.IsEmpty() ? nullptr : element.GetValueAsSQ();
}

}  // namespace

std::string element_name(DicomTag tag) {
  const gdcm::DictEntry& entry = gdcm::Global::GetInstance().GetDicts().GetPublicDict().GetDictEntry(tag_of(tag));
  const std::string name = entry.GetVR() == gdcm::VR::INVALID || !entry.GetName() ? "element" : entry.GetName();
  return name + " (" + hexadecimal_text(tag.group, 4) + "," + hexadecimal_text(tag.element, 4) + ")";
}

void throw_invalid(const gdcm::DataSet& data, DicomTag tag, const std::string& reason) {
  throw InvalidElement("its " + element_name(tag) + " is '" + text_of(data, tag, 60) + "', " + reason);
}

bool has(const gdcm::DataSet& data, DicomTag tag) { return data.FindDataElement(tag_of(tag)); }

std::string text_of(const gdcm::DataSet& data, DicomTag tag, std::size_t limit) {
  const gdcm::ByteValue* value = bytes_of(data, tag);
  return value ? one_line(std::string(value->GetPointer(), value->GetLength()), limit) : std::string();
}

std::string raw_text_of(const gdcm::DataSet& data, DicomTag tag) {
  const gdcm::ByteValue* value = bytes_of(data, tag);
  std::string text = value ? std::string(value->GetPointer(), value->GetLength()) : std::string();
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::vector<double> numbers_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind) {
  const gdcm::ByteValue* value = bytes_of(data, tag);
  if (!value) return {};
  switch (kind) {
    case DicomKind::Short:
      return binary_numbers<std::uint16_t>(tag, *value);
    case DicomKind::Long:
      return binary_numbers<std::uint32_t>(tag, *value);
    case DicomKind::Double:
      return binary_numbers<double>(tag, *value);
    case DicomKind::Text:
      break;
  }
  return text_numbers(data, tag, *value);
}

std::vector<double> numbers_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind, std::size_t count) {
  std::vector<double> numbers = numbers_of(data, tag, kind);
  if (!numbers.empty() && numbers.size() != count) {
    const std::string found = counted(static_cast<std::int64_t>(numbers.size()), "value");
    throw InvalidElement("its " + element_name(tag) + " has " + found + " instead of " + std::to_string(count));
  }
  return numbers;
}

std::optional<double> number_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind) {
  const std::vector<double> numbers =
      kind == DicomKind::Text ? numbers_of(data, tag, kind, 1) : numbers_of(data, tag, kind);
  return numbers.empty() ? std::nullopt : std::optional(numbers.front());
}

std::optional<double> integer_of(const gdcm::DataSet& data, DicomTag tag) {
  const std::optional<double> number = number_of(data, tag);
  if (number && *number != std::rint(*number)) throw_invalid(data, tag, "which is not an integer");
  return number;
}

int short_of(const gdcm::DataSet& data, DicomTag tag, int otherwise) {
  const auto number = number_of(data, tag, DicomKind::Short);
  return number ? static_cast<int>(*number) : otherwise;
}

void each_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f) {
  const auto items = items_of(data, sequence);
  if (!items) return;
  for (std::size_t i = 1; i <= items->GetNumberOfItems(); ++i) f(items->GetItem(i).GetNestedDataSet());
}

bool first_item(const gdcm::DataSet& data, DicomTag sequence, const std::function<void(const gdcm::DataSet&)>& f) {
  const auto items = items_of(data, sequence);
  if (!items || items->GetNumberOfItems() == 0) return false;
  f(items->GetItem(1).GetNestedDataSet());
  return true;
}

}  // namespace simplexseg
