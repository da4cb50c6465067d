// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_item.h"

#include <gdcmDict.h>
#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmUIDGenerator.h>
#include <gdcmWriter.h>

#include <charconv>
#include <sstream>
#include <streambuf>

#include "core/expect.h"
#include "io/dicom/gdcm_tag.h"
#include "io/platform/atomic_file.h"

namespace simplexseg {
namespace {

gdcm::VR vr_of(DicomTag tag) {
  constexpr DicomTag kSegmentsOverlap{0x0062, 0x0013};  // missing in the dictionary of GDCM 3.0
  if (tag_of(tag) == tag_of(kSegmentsOverlap)) return gdcm::VR::CS;
  const gdcm::VR vr = gdcm::Global::GetInstance().GetDicts().GetPublicDict().GetDictEntry(tag_of(tag)).GetVR();
  SIMPLEXSEG_ENSURE(vr != gdcm::VR::INVALID);
  if (vr == gdcm::VR::US_SS) return gdcm::VR::US;
  return vr == gdcm::VR::OB_OW ? gdcm::VR(gdcm::VR::OB) : vr;
}

/// Stream buffer that writes into an AtomicFile.
class FileBuffer : public std::streambuf {
 public:
  explicit FileBuffer(AtomicFile& file) : file_(file) {}

 protected:
  int_type overflow(int_type c) override {
    const char byte = traits_type::to_char_type(c);
    xsputn(&byte, 1);
    return traits_type::not_eof(c);
  }
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    pending_.append(bytes, static_cast<std::size_t>(count));
    if (pending_.size() > (1u << 16)) sync();
    return count;
  }
  int sync() override {
    file_.write(pending_.data(), pending_.size());
    pending_.clear();
    return 0;
  }

 private:
  AtomicFile& file_;
  std::string pending_;
};

}  // namespace

DicomItem::DicomItem() : data_(std::make_unique<gdcm::DataSet>()) {}
DicomItem::DicomItem(DicomItem&&) noexcept = default;
DicomItem& DicomItem::operator=(DicomItem&&) noexcept = default;
DicomItem::~DicomItem() = default;

void DicomItem::set_value(DicomTag tag, const void* bytes, std::size_t count) {
  gdcm::DataElement element(tag_of(tag));
  element.SetVR(vr_of(tag));
  element.SetByteValue(static_cast<const char*>(bytes), gdcm::VL(static_cast<std::uint32_t>(count)));
  data_->Replace(element);
}

DicomItem& DicomItem::text(DicomTag tag, const std::string& value) {
  std::string padded = value;
  if (padded.size() % 2) padded += vr_of(tag) == gdcm::VR::UI ? '\0' : ' ';
  set_value(tag, padded.data(), padded.size());
  return *this;
}

DicomItem& DicomItem::shorts(DicomTag tag, std::span<const std::uint16_t> values) {
  set_value(tag, values.data(), values.size_bytes());
  return *this;
}

DicomItem& DicomItem::longs(DicomTag tag, std::span<const std::uint32_t> values) {
  set_value(tag, values.data(), values.size_bytes());
  return *this;
}

DicomItem& DicomItem::pointer(DicomTag tag, DicomTag to) {
  const std::uint16_t parts[] = {to.group, to.element};
  set_value(tag, parts, sizeof parts);
  return *this;
}

DicomItem& DicomItem::numbers(DicomTag tag, std::span<const double> values) {
  std::string all;
  for (const double value : values) all.append(all.empty() ? "" : "\\").append(decimal_string(value));
  return text(tag, all);
}

DicomItem& DicomItem::bytes(DicomTag tag, const std::vector<std::uint8_t>& values) {
  SIMPLEXSEG_EXPECT(values.size() % 2 == 0);
  set_value(tag, values.data(), values.size());
  return *this;
}

DicomItem& DicomItem::words(DicomTag tag, std::span<const std::uint16_t> values) {
  gdcm::DataElement element(tag_of(tag));
  element.SetVR(gdcm::VR::OW);
  element.SetByteValue(reinterpret_cast<const char*>(values.data()),
                       gdcm::VL(static_cast<std::uint32_t>(values.size_bytes())));
  data_->Replace(element);
  return *this;
}

DicomItem& DicomItem::items(DicomTag tag, std::span<const DicomItem> items) {
  gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = new gdcm::SequenceOfItems;
  sequence->SetLengthToUndefined();
  for (const DicomItem& one : items) {
    gdcm::Item item;
    item.SetVLToUndefined();
    item.SetNestedDataSet(*one.data_);
    sequence->AddItem(item);
  }
  gdcm::DataElement element(tag_of(tag));
  element.SetVR(gdcm::VR::SQ);
  element.SetValue(*sequence);
  element.SetVLToUndefined();
  data_->Replace(element);
  return *this;
}

DicomItem& DicomItem::item(DicomTag tag, const DicomItem& one) { return items(tag, {&one, 1}); }

DicomItem& DicomItem::code(DicomTag tag, const std::string& value, const std::string& scheme,
                           const std::string& meaning) {
  DicomItem one;
  one.text({0x0008, 0x0100}, value).text({0x0008, 0x0102}, scheme).text({0x0008, 0x0104}, meaning);
  return item(tag, one);
}

DicomItem& DicomItem::remove(DicomTag tag) {
  data_->Remove(tag_of(tag));
  return *this;
}

std::string decimal_string(double value) {
  char text[40];
  char* end = std::to_chars(text, text + sizeof text, value).ptr;
  for (int digits = 16; end - text > 16 && digits > 0; --digits)
    end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr;
  return {text, end};
}

std::string new_dicom_uid() { return gdcm::UIDGenerator().Generate(); }

std::string dicom_bytes(const DicomItem& data) {
  std::ostringstream stream;
  data.data_->Write<gdcm::ExplicitDataElement, gdcm::SwapperNoOp>(stream);
  return std::move(stream).str();
}

void write_dicom(AtomicFile& file, const DicomItem& data, DicomCoding coding) {
  FileBuffer buffer(file);
  std::ostream stream(&buffer);
  stream.exceptions(std::ios::badbit);  // errors of AtomicFile propagate through the stream
  gdcm::Writer writer;
  writer.SetStream(stream);
  writer.GetFile().SetDataSet(*data.data_);
  writer.GetFile().GetHeader().SetDataSetTransferSyntax(coding == DicomCoding::Implicit
                                                            ? gdcm::TransferSyntax::ImplicitVRLittleEndian
                                                            : gdcm::TransferSyntax::ExplicitVRLittleEndian);
  if (!writer.Write()) throw file.failed("the DICOM library rejected the data");
  stream.flush();
}

}  // namespace simplexseg
