// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_values.h"

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <locale>
#include <sstream>

#include "io/dicom/gdcm_tag.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

const gdcm::ByteValue* bytes_of(const gdcm::DataSet& data, DicomTag tag) {
  if (!data.FindDataElement(tag_of(tag))) return nullptr;
  return data.GetDataElement(tag_of(tag)).GetByteValue();
}

template <class T>
std::vector<double> binary_numbers(const gdcm::ByteValue& value) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at + sizeof(T) <= value.GetLength(); at += sizeof(T)) {
    T number;
    std::memcpy(&number, value.GetPointer() + at, sizeof number);
    if (!std::isfinite(static_cast<double>(number))) break;
    numbers.push_back(static_cast<double>(number));
  }
  return numbers;
}

std::vector<double> text_numbers(const gdcm::ByteValue& value) {
  std::string text(value.GetPointer(), value.GetLength());
  std::replace(text.begin(), text.end(), '\\', ' ');
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double number = 0; stream >> number && std::isfinite(number);) numbers.push_back(number);
  return numbers;
}

gdcm::SmartPointer<gdcm::SequenceOfItems> items_of(const gdcm::DataSet& data, DicomTag sequence) {
  if (!data.FindDataElement(tag_of(sequence))) return nullptr;
  const gdcm::DataElement& element = data.GetDataElement(tag_of(sequence));
  return element.IsEmpty() ? nullptr : element.GetValueAsSQ();
}

}  // namespace

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
      return binary_numbers<std::uint16_t>(*value);
    case DicomKind::Long:
      return binary_numbers<std::uint32_t>(*value);
    case DicomKind::Double:
      return binary_numbers<double>(*value);
    case DicomKind::Text:
      break;
  }
  return text_numbers(*value);
}

std::optional<double> number_of(const gdcm::DataSet& data, DicomTag tag, DicomKind kind) {
  const std::vector<double> numbers = numbers_of(data, tag, kind);
  return numbers.empty() ? std::nullopt : std::optional(numbers.front());
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
