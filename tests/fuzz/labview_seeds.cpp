#include "fuzz/harness.hpp"

std::vector<std::string> fuzz::seeds() {
  return {
      "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
      "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\n***End_of_Header***\t\n\nChannels\t2\t\t\n"
      "Samples\t4\t4\t\nY_Unit_Label\tmm\tg\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\nDelta_X\t0.01\t0.01\t\n"
      "***End_of_Header***\t\t\t\nX_Value\tx\tddr\tComment\n0.0\t1\t2\n0.01\t2\t3\n0.02\t3\t4\n0.03\t4\t5\n",
      "LabVIEW Measurement,\nSeparator,Comma\nDecimal_Separator,.\nMulti_Headings,Yes\nX_Columns,No\n"
      "***End_of_Header***,\n\nChannels,2,\nSamples,3,3,\nDelta_X,0.5,0.5,\n***End_of_Header***,\n"
      "X_Value,y,x,Comment\n,1,2\n,2,3\n,3,4\n",
      "LabVIEW Measurement\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tMulti\n***End_of_Header***\n"
      "Channels\t2\nDelta_X\t0,1\t0,1\n***End_of_Header***\nX_Value\tx\tX_Value\ty\n0,0\t1,5\t0,0\t2\n"
      "0,1\t2,5\t0,1\t3\n"};
}
