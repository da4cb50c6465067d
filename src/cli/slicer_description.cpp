// SPDX-License-Identifier: Apache-2.0
// Elements stand in the order of the schema of CTK (ctkCmdLineModule.xsd), which 3D Slicer's own parser takes in any.
#include "cli/slicer_description.h"

namespace simplexseg {

std::string slicer_description() {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<executable>
  <category>Segmentation</category>
  <title>SimplexSeg</title>
  <description>Grows a closed surface from each seed to the edges of its object, and writes the voxels inside. Put a point into the middle of each object; where there is one object alone, further points say what is inside, outside or on its boundary.</description>
  <version>)" SIMPLEXSEG_VERSION R"(</version>
  <documentation-url></documentation-url>
  <license>Apache-2.0</license>
  <contributor>The maintainers of SimplexSeg</contributor>
  <parameters>
    <label>Image and labels</label>
    <description>What is segmented, and where the result goes</description>
    <image>
      <name>image</name>
      <index>0</index>
      <description>Image to be segmented</description>
      <label>Image</label>
      <channel>input</channel>
    </image>
    <image type="label">
      <name>labels</name>
      <index>1</index>
      <description>Voxels inside the surfaces: 1 for the first seed, 2 for the second, ...</description>
      <label>Labels</label>
      <channel>output</channel>
    </image>
  </parameters>
  <parameters>
    <label>Objects</label>
    <description>Where the objects are</description>
    <point multiple="true" coordinateSystem="lps">
      <name>seed</name>
      <longflag>seed</longflag>
      <description>A point in the middle of each object</description>
      <label>Seeds</label>
    </point>
    <double>
      <name>radius</name>
      <longflag>radius</longflag>
      <description>Radius of the seeds in mm, as large as fits into the objects</description>
      <label>Radius (mm)</label>
      <default>10</default>
      <constraints>
        <minimum>0.1</minimum>
        <maximum>200</maximum>
        <step>0.5</step>
      </constraints>
    </double>
    <point multiple="true" coordinateSystem="lps">
      <name>inside</name>
      <longflag>inside</longflag>
      <description>Points inside of the one object</description>
      <label>Inside</label>
    </point>
    <point multiple="true" coordinateSystem="lps">
      <name>outside</name>
      <longflag>outside</longflag>
      <description>Points outside of the one object</description>
      <label>Outside</label>
    </point>
    <point multiple="true" coordinateSystem="lps">
      <name>boundary</name>
      <longflag>boundary</longflag>
      <description>Points that the surface of the one object is to pass</description>
      <label>Boundary</label>
    </point>
  </parameters>
  <parameters advanced="true">
    <label>How</label>
    <description>Settings, and what computes</description>
    <file fileExtensions=".json">
      <name>scene</name>
      <longflag>scene</longflag>
      <description>Scene whose parameters, and meshes where it has any, are taken</description>
      <label>Template scene</label>
      <channel>input</channel>
    </file>
    <string-enumeration>
      <name>backend</name>
      <longflag>backend</longflag>
      <description>auto takes CUDA where a device can be used, else the CPU</description>
      <label>Computed by</label>
      <default>auto</default>
      <element>auto</element>
      <element>cpu</element>
      <element>cuda</element>
    </string-enumeration>
    <directory>
      <name>meshes</name>
      <longflag>meshes</longflag>
      <description>Folder for the surfaces, as PLY files</description>
      <label>Folder for surfaces</label>
      <channel>output</channel>
    </directory>
    <file fileExtensions=".json">
      <name>report</name>
      <longflag>report</longflag>
      <description>Figures of the run</description>
      <label>Report</label>
      <channel>output</channel>
    </file>
  </parameters>
</executable>
)";
}

}  // namespace simplexseg
