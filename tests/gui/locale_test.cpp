// SPDX-License-Identifier: Apache-2.0
// Numbers of the window under the locale of the environment; tests/locale/run repeats these tests under other locales.
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QLineEdit>
#include <QPushButton>

#include "../io/dicom_slices.h"
#include "gui/look/integer_box.h"
#include "gui/look/number_box.h"
#include "gui/window/file_actions.h"
#include "gui/window/series_dialog.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class LocaleTest : public WindowTest {};

TEST_F(LocaleTest, APointAndACommaAreDecimalSigns) {
  NumberBox box(nullptr);
  box.setRange(0, 5000);
  box.setDecimals(2);
  box.setSuffix(" mm");
  for (const char* typed : {"1.5", "1,5"}) {
    box.setValue(0);
    box.findChild<QLineEdit*>()->setText(typed);
    box.interpretText();
    EXPECT_EQ(box.value(), 1.5) << typed;
    EXPECT_EQ(box.text(), "1.50 mm");
  }
  box.setValue(1234.5);
  EXPECT_EQ(box.text(), "1234.50 mm");
}

TEST_F(LocaleTest, AWholeNumberHasNoSeparators) {
  IntegerBox box(nullptr);
  box.setRange(1, 65535);
  for (const char* typed : {"1,5", "1.5"}) {
    QString text = typed;
    int position = 3;
    EXPECT_EQ(box.validate(text, position), QValidator::Invalid) << typed;
  }
  box.setValue(1500);
  EXPECT_EQ(box.text(), "1500");
}

TEST_F(LocaleTest, EveryNumberFieldOfTheWindowShowsAPoint) {
  open_phantom();
  const auto fields = window_->findChildren<QDoubleSpinBox*>();
  EXPECT_FALSE(fields.isEmpty());
  for (QDoubleSpinBox* field : fields) EXPECT_FALSE(field->text().contains(',')) << field->text().toStdString();
}

TEST_F(LocaleTest, TheFirstEchoIsTheFirstVolume) {
  test::write_echoes(folder_.filePath("echoes").toStdString());
  window_->files().open(folder_.filePath("echoes"));
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SeriesDialog*>() != nullptr; }));
  // Volume 1 is selected in the dialog.
  window_->findChild<SeriesDialog*>()->findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Open)->click();
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().value(0, 0, 0), 46);
}

}  // namespace
}  // namespace simplexseg
