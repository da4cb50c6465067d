// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>

namespace simplexseg {

class ViewGrid;

/// Menu of the layouts of views: all four, one large view beside the others, three neighbouring slices with the
/// distance between them, or one view alone.
class ViewLayoutMenu : public QMenu {
  Q_OBJECT
 public:
  ViewLayoutMenu(ViewGrid& views, QWidget* parent);
};

}  // namespace simplexseg
