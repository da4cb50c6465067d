// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_write/dicom_sr_write.h"

#include "core/error.h"
#include "io/platform/files.h"

#ifdef SIMPLEXSEG_HAS_DCMTK

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcistrmb.h>
#include <dcmtk/dcmdata/dcostrmb.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmsr/cmr/tid1500.h>
#include <dcmtk/dcmsr/codes/dcm.h>
#include <dcmtk/dcmsr/codes/ucum.h>
#include <dcmtk/dcmsr/dsrdoc.h>

#include <algorithm>
#include <mutex>
#include <set>

#include "core/number_text.h"
#include "io/platform/atomic_file.h"

namespace simplexseg {
namespace {

using Group = TID1500_MeasurementReport::TID1411_Measurements;
using Quantity = CID7469_GenericIntensityAndSizeMeasurements;
using Unit = CID7181_AbstractMultiDimensionalImageModelComponentUnits;
using Derivation = CID7464_GeneralRegionOfInterestMeasurementModifiers;

/// Identifies the program as observer (TID 1004); a UUID as UID (PS3.5 B.2).
constexpr const char* kDeviceUid = "2.25.191353267203921841690148563093408245101";
constexpr int kDigits = 7;                                 ///< significant digits of measures, as in tables
constexpr const char* kAnatomicalStructure = "123037004";  // SNOMED CT, category of CID 7150

/// Throws Error for a status of DCMTK that is an error.
void require_good(const OFCondition& status, const std::filesystem::path& path) {
  if (status.bad())
    throw Error("cannot write " + quoted(path), std::string("the DICOM library reports: ") + status.text(),
                "check names and codes of the segmentations");
}

DSRCodedEntryValue entry_of(const CodedConcept& code, const DicomSource& source) {
  return {code.value, code.scheme, dicom_name(code.meaning, source)};
}

/// Quantity and unit of the intensities of the image (CID 7469 and 7181). Images whose values have no meaning by
/// themselves get a private code.
struct IntensityMeaning {
  Quantity quantity;
  Unit unit;
};

IntensityMeaning meaning_of(const std::string& unit, const std::string& modality) {
  if (unit == "HU") return {Quantity::AttenuationCoefficient, Unit::HounsfieldUnit};
  if (unit == "SUV" || unit == "g/ml") return {Quantity::SUVbw, Unit::StandardizedUptakeValueBodyWeight};
  if (unit == "g/ml (LBM)") return {Quantity::SUVlbm, Unit::StandardizedUptakeValueLeanBodyMassJames};
  if (unit == "g/ml (LBMJAMES128)")
    return {Quantity::SUVlbmJames128, Unit::StandardizedUptakeValueLeanBodyMassJames128Multiplier};
  if (unit == "g/ml (LBMJANMA)") return {Quantity::SUVlbmJanma, Unit::StandardizedUptakeValueLeanBodyMassJanma};
  if (unit == "g/ml (IBW)") return {Quantity::SUVibw, Unit::StandardizedUptakeValueIdealBodyWeight};
  const DSRCodedEntryValue intensity("intensity", "99SIMPLEXSEG", "Intensity of voxels");
  if (unit == "Bq/ml") return {intensity, Unit::BecquerelsPerMilliliter};
  if (unit == "counts") return {intensity, Unit::Counts};
  if (modality == "MR") return {Quantity::MRSignalIntensity, Unit::NoUnits};
  return {intensity, Unit::NoUnits};
}

/// Procedure that made the image (CID 100).
CID100_QuantitativeDiagnosticImagingProcedures procedure_of(const std::string& modality) {
  using Procedure = CID100_QuantitativeDiagnosticImagingProcedures;
  if (modality == "CT") return Procedure::CTUnspecifiedBodyRegion;
  if (modality == "MR") return Procedure::MRIUnspecifiedBodyRegion;
  if (modality == "PT") return Procedure::PETUnspecifiedBodyRegion;
  return DSRCodedEntryValue("363679005", "SCT", "Imaging procedure");
}

const WrittenSegment& segment_of(int label, const WrittenSegmentation& segmentation,
                                 const std::filesystem::path& path) {
  for (const WrittenSegment& segment : segmentation.segments)
    if (segment.label == label) return segment;
  throw Error("cannot write " + quoted(path), "the segmentation has no label " + std::to_string(label),
              "write both files together");
}

/// Fills measurement groups; throws Error as write_structured_report().
class ReportBuilder {
 public:
  ReportBuilder(const std::filesystem::path& path, const std::string& unit, const WrittenSegmentation& segmentation,
                const DicomSource& source)
      : path_(path), meaning_(meaning_of(unit, source.modality)), segmentation_(segmentation), source_(source) {
    check(report_.setLanguage(CID5000_Languages::English));
    check(report_.getObservationContext().addDeviceObserver(kDeviceUid, "", "SimplexSeg", "SimplexSeg"));
    check(report_.addProcedureReported(procedure_of(source.modality)));
  }

  void add(const ReportedObject& object) {
    check(report_.addVolumetricROIMeasurements());
    Group& group = report_.getVolumetricROIMeasurements();
    const WrittenSegment& segment = segment_of(object.label, segmentation_, path_);
    check(group.setTrackingIdentifier(segment.tracking_id));
    check(group.setTrackingUniqueIdentifier(segment.tracking_uid));
    const SegmentCode& code = object.code.empty() ? tissue_code() : object.code;
    check(group.setFinding(entry_of(code.type, source_)));
    DSRImageReferenceValue reference(segmentation_.sop_class, segmentation_.sop_instance);
    reference.getSegmentList().addItem(static_cast<Uint16>(segment.number));
    check(group.setReferencedSegment(reference));
    check(group.setSourceSeriesForSegmentation(source_.series));
    if (code.category.value == kAnatomicalStructure) add_site(group, code);
    const ObjectMeasures& measures = object.measures;
    add(group, Quantity::Volume, measures.volume_mm3, Unit::CubicMillimeter);
    if (measures.intensities) {
      add(group, meaning_.quantity, measures.intensities->mean, meaning_.unit);
      check(group.getMeasurement().setDerivation(Derivation::Mean));
      add(group, meaning_.quantity, measures.intensities->deviation, meaning_.unit);
      check(group.getMeasurement().setDerivation(Derivation::StandardDeviation));
    }
    if (!measures.axes) return;
    add(group, Quantity::LongAxis, measures.axes->long_mm(), Unit::Millimeter);
    add(group, Quantity::ShortAxis, measures.axes->short_mm(), Unit::Millimeter);
  }

  /// Returns the data set of the report, with patient, study and equipment of `context`.
  DcmDataset finish(const DicomItem& context) {
    DSRDocument document(DSRTypes::DT_Comprehensive3DSR);
    check(document.setTreeFromRootTemplate(report_));
    DSRSOPInstanceReferenceList& evidence = document.getCurrentRequestedProcedureEvidence();
    const auto refer = [&](const std::string& series, const std::string& sop_class, const std::string& instance) {
      check(evidence.addItem(source_.study, series, sop_class, instance));
    };
    refer(segmentation_.series, segmentation_.sop_class, segmentation_.sop_instance);
    for (const DicomInstance& slice : source_.slices) refer(source_.series, slice.sop_class, slice.sop_instance);
    check(document.completeDocument());
    DcmDataset data;
    check(document.write(data));
    std::string bytes = dicom_bytes(context);
    DcmInputBufferStream stream;
    stream.setBuffer(bytes.data(), static_cast<offile_off_t>(bytes.size()));
    stream.setEos();
    DcmDataset own;
    own.transferInit();
    check(own.read(stream, EXS_LittleEndianExplicit));
    own.transferEnd();
    while (own.card() > 0) check(data.insert(own.remove(0UL), OFTrue));
    return data;
  }

 private:
  void check(const OFCondition& status) const { require_good(status, path_); }

  void add(Group& group, const Quantity& quantity, double value, const Unit& unit) const {
    check(group.addMeasurement(quantity, Group::MeasurementValue(general_text(value, kDigits), unit)));
  }

  void add_site(Group& group, const SegmentCode& code) const {
    const DSRCodedEntryValue side = code.modifier.empty() ? DSRCodedEntryValue() : entry_of(code.modifier, source_);
    check(group.addFindingSite(entry_of(code.type, source_), CID244e_Laterality(side)));
  }

  const std::filesystem::path& path_;
  IntensityMeaning meaning_;
  const WrittenSegmentation& segmentation_;
  const DicomSource& source_;
  TID1500_MeasurementReport report_{CID7021_MeasurementReportDocumentTitles::ImagingMeasurementReport};
};

std::vector<char> file_bytes(DcmDataset& data, const std::filesystem::path& path) {
  DcmFileFormat file(&data);
  require_good(file.validateMetaInfo(EXS_LittleEndianExplicit), path);
  std::vector<char> bytes(file.calcElementLength(EXS_LittleEndianExplicit, EET_UndefinedLength) + 1024);
  DcmOutputBufferStream stream(bytes.data(), static_cast<offile_off_t>(bytes.size()));
  file.transferInit();
  require_good(file.write(stream, EXS_LittleEndianExplicit, EET_UndefinedLength, nullptr), path);
  file.transferEnd();
  void* written = nullptr;
  offile_off_t count = 0;
  stream.flushBuffer(written, count);
  bytes.resize(static_cast<std::size_t>(count));
  return bytes;
}

}  // namespace

void require_structured_reports(const std::filesystem::path&) {}

void write_structured_report(const std::filesystem::path& path, const std::vector<ReportedObject>& objects,
                             const std::string& unit, const WrittenSegmentation& segmentation, DicomSource source) {
  std::set<int> labels;
  for (const ReportedObject& object : objects)
    if (!labels.insert(object.label).second)
      throw Error("cannot write " + quoted(path), "two segmentations have the label " + std::to_string(object.label),
                  "give each its own label");
  static std::mutex code_lists;  // DCMTK creates its lists of codes at their first use
  const std::lock_guard lock(code_lists);
  DicomItem context = std::move(source.context);
  context.remove({0x0020, 0x0052}).remove({0x0020, 0x1040});  // a report has no position in space
  const DicomDateTime now = dicom_now();
  add_common_attributes(context, UID_Comprehensive3DSRStorage, "SR", now);
  context.text({0x0008, 0x0023}, now.date).text({0x0008, 0x0033}, now.time);
  context.text({0x0008, 0x103e}, "Measurements by SimplexSeg");
  ReportBuilder builder(path, unit, segmentation, source);
  for (const ReportedObject& object : objects) builder.add(object);
  DcmDataset data = builder.finish(context);
  const std::vector<char> bytes = file_bytes(data, path);
  AtomicFile file(path);
  file.write(bytes.data(), bytes.size());
  file.commit();
}

}  // namespace simplexseg

#else

namespace simplexseg {

void require_structured_reports(const std::filesystem::path& path) {
  throw Error("cannot write " + quoted(path), "this program was built without DCMTK", "build it with libdcmtk-dev");
}

void write_structured_report(const std::filesystem::path& path, const std::vector<ReportedObject>&, const std::string&,
                             const WrittenSegmentation&, DicomSource) {
  require_structured_reports(path);
}

}  // namespace simplexseg

#endif
