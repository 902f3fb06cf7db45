// Writes tables that compare real descriptors with the model's, for plotting.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_PLOTS_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_PLOTS_H_

#include <string>

#include "lab/descriptors/descriptor_fit.h"

namespace cairn {

// Writes spectrum.csv, angle.csv, scale.csv, nearest.csv, same_and_other.csv and crowd.csv to the
// folder `output_dir`, which is created. descriptor_plots.gnuplot draws them. Throws Error(kIo)
// that names the file.
void WriteDescriptorPlots(const DescriptorFitData& data, const DescriptorModelOptions& options,
                          const std::string& output_dir);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_PLOTS_H_
