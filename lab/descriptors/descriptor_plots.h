// Tables of real descriptors beside those of the model, for plotting.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_PLOTS_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_PLOTS_H_

#include <string>

#include "lab/descriptors/descriptor_fit.h"

namespace cairn {

// Writes spectrum.csv, angle.csv, scale.csv, nearest.csv, same_and_other.csv and crowd.csv to a
// folder that it makes; descriptor_plots.gnuplot draws them. Throws Error(kIo) naming the file.
void WriteDescriptorPlots(const DescriptorFitData& data, const DescriptorModelOptions& options,
                          const std::string& output_dir);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_PLOTS_H_
