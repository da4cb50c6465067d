// SPDX-License-Identifier: Apache-2.0
#include "gui/window/theme_settings.h"

#include <QActionGroup>
#include <QApplication>
#include <QDBusConnection>
#include <QFileInfo>
#include <QMenu>
#include <algorithm>
#include <iterator>

namespace simplexseg {
namespace {
constexpr const char *kTheme = "theme", *kText = "text_percent";
const char* const kNames[] = {"desktop", "dark", "light"};
}  // namespace

ThemeSettings::ThemeSettings(QApplication& application, std::optional<theme::Choice> instead)
    : application_(application), settings_(QSettings::IniFormat, QSettings::UserScope, "simplexseg", "window") {
  const QString name = settings_.value(kTheme).toString();
  for (int n = 0; n < 3; ++n)
    if (name == kNames[n]) choice_ = static_cast<theme::Choice>(n);
  choice_ = instead.value_or(choice_);
  const int percent = settings_.value(kText, 100).toInt();
  if (std::count(std::begin(theme::kTextSizes), std::end(theme::kTextSizes), percent)) text_percent_ = percent;
  apply();
  if (!qEnvironmentVariableIsEmpty("DBUS_SESSION_BUS_ADDRESS"))
    QDBusConnection::sessionBus().connect("org.freedesktop.portal.Desktop", "/org/freedesktop/portal/desktop",
                                          "org.freedesktop.portal.Settings", "SettingChanged", this,
                                          SLOT(desktop_changed()));
}

void ThemeSettings::apply() {
  const bool dark = choice_ == theme::Choice::Desktop ? theme::desktop_is_dark() : choice_ == theme::Choice::Dark;
  theme::apply(application_, dark, text_percent_);
}

void ThemeSettings::choose(theme::Choice choice) {
  choice_ = choice;
  settings_.setValue(kTheme, kNames[static_cast<int>(choice)]);
  apply();
}

void ThemeSettings::choose_text(int percent) {
  text_percent_ = percent;
  settings_.setValue(kText, percent);
  emit message(tr("The new text size takes effect when SimplexSeg is started again"));
}

// Called when any setting of the desktop has changed; reading the theme is cheap.
void ThemeSettings::desktop_changed() {
  if (choice_ == theme::Choice::Desktop && theme::desktop_is_dark() != theme::is_dark()) apply();
}

void ThemeSettings::fill(QMenu& menu) {
  menu.addSeparator();
  QMenu* themes = menu.addMenu(tr("&Theme"));
  auto* group = new QActionGroup(themes);
  const QString titles[] = {tr("Same as &desktop"), tr("D&ark"), tr("&Light")};
  for (int n = 0; n < 3; ++n) {
    QAction* entry = themes->addAction(titles[n], this, [this, n] { choose(static_cast<theme::Choice>(n)); });
    entry->setCheckable(true);
    entry->setChecked(static_cast<int>(choice_) == n);
    group->addAction(entry);
  }
  QMenu* sizes = menu.addMenu(tr("Text si&ze"));
  auto* size_group = new QActionGroup(sizes);
  for (const int percent : theme::kTextSizes) {
    QAction* entry = sizes->addAction(tr("%1 %").arg(percent), this, [this, percent] { choose_text(percent); });
    entry->setCheckable(true);
    entry->setChecked(percent == text_percent_);
    size_group->addAction(entry);
  }
}

}  // namespace simplexseg
