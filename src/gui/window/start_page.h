// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

class QVBoxLayout;

namespace simplexseg {

class ActionTable;

/// What lies over the views while there is no volume: the ways to one.
class StartPage : public QWidget {
  Q_OBJECT
 public:
  StartPage(ActionTable& actions, QWidget* over);
  /// Files that were opened before, the latest first; those that are gone are left out.
  void show_recent(const QStringList& paths);

 signals:
  void open_wanted(const QString& path);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void add_path(const QString& title, const QString& path);

  QWidget* recent_ = nullptr;
  QVBoxLayout* recent_column_ = nullptr;
};

}  // namespace simplexseg
