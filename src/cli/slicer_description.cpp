// SPDX-License-Identifier: Apache-2.0
// The elements have the order of the CTK schema (ctkCmdLineModule.xsd); the parser of 3D Slicer accepts any order.
#include "cli/slicer_description.h"

namespace simplexseg {

std::string slicer_description() {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<executable>
  <category>Segmentation</category>
  <title>SimplexSeg</title>
  <description>Grows a closed surface from each seed to the border of its object and writes the voxels inside as labels. Place one seed in the middle of each object. With a single object, further points mark its inside, outside or boundary.</description>
  <version>)" SIMPLEXSEG_VERSION R"(</version>
  <documentation-url></documentation-url>
  <license>Apache-2.0</license>
  <contributor>The maintainers of SimplexSeg</contributor>
  <parameters>
    <label>Image and labels</label>
    <description>Input image and output label map</description>
    <image>
      <name>image</name>
      <index>0</index>
      <description>Image to segment</description>
      <label>Image</label>
      <channel>input</channel>
    </image>
    <image type="label">
      <name>labels</name>
      <index>1</index>
      <description>Label map of the result: 1 for the first seed, 2 for the second, ...</description>
      <label>Labels</label>
      <channel>output</channel>
    </image>
  </parameters>
  <parameters>
    <label>Objects</label>
    <description>Position and size of the objects</description>
    <point multiple="true" coordinateSystem="lps">
      <name>seed</name>
      <longflag>seed</longflag>
      <description>One point in the middle of each object</description>
      <label>Seeds</label>
    </point>
    <double>
      <name>radius</name>
      <longflag>radius</longflag>
      <description>Radius of the seeds, mm; the largest ball that fits into the objects works best</description>
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
      <description>Points inside the object (single object only)</description>
      <label>Inside</label>
    </point>
    <point multiple="true" coordinateSystem="lps">
      <name>outside</name>
      <longflag>outside</longflag>
      <description>Points outside the object (single object only)</description>
      <label>Outside</label>
    </point>
    <point multiple="true" coordinateSystem="lps">
      <name>boundary</name>
      <longflag>boundary</longflag>
      <description>Points on the boundary of the object (single object only)</description>
      <label>Boundary</label>
    </point>
  </parameters>
  <parameters advanced="true">
    <label>Settings</label>
    <description>Template scene, processor and further outputs</description>
    <file fileExtensions=".json">
      <name>scene</name>
      <longflag>scene</longflag>
      <description>Scene that provides parameters and, if it has any, meshes</description>
      <label>Template scene</label>
      <channel>input</channel>
    </file>
    <string-enumeration>
      <name>backend</name>
      <longflag>backend</longflag>
      <description>Processor: cpu, cuda, or auto: CUDA if a device is available, else the CPU</description>
      <label>Processor</label>
      <default>auto</default>
      <element>auto</element>
      <element>cpu</element>
      <element>cuda</element>
    </string-enumeration>
    <directory>
      <name>meshes</name>
      <longflag>meshes</longflag>
      <description>Output folder for the surfaces (PLY)</description>
      <label>Surface folder</label>
      <channel>output</channel>
    </directory>
    <file fileExtensions=".json">
      <name>report</name>
      <longflag>report</longflag>
      <description>Report of the run (JSON)</description>
      <label>Report</label>
      <channel>output</channel>
    </file>
  </parameters>
</executable>
)";
}

}  // namespace simplexseg
