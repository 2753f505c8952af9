#include "compiler/work/engine_scripts.h"

#include "formats/text/quoted_text.h"
#include "passes/pass/pass.h"

namespace sightline {
namespace {

// A file name of sbatch, where % begins what it replaces.
std::string sbatch_name(const std::string& path) {
  std::string name;
  for (const char c : path) name += c == '%' ? "%%" : std::string(1, c);
  return shell_word(name);
}

std::string work_command(const EngineJob& job, Stage stage) {
  return shell_word(job.program.string()) + " work " + shell_word(job.plan.string()) + " --stage " +
         std::string(stage_name(stage));
}

std::string link_command(const EngineJob& job) {
  return shell_word(job.program.string()) + " link " + shell_word(job.plan.string()) + " -o " +
         shell_word(job.map.string()) + " --force";
}

int shares_of(const EngineJob& job, Stage stage) { return is_shared(stage) ? job.shares : 1; }

std::string slurm_script(const EngineJob& job) {
  const std::string threads = " --threads \"${SLURM_CPUS_PER_TASK:-1}\"";
  const std::string folder = (job.plan / "log").string();
  const std::string logs = sbatch_name(folder);
  std::string text =
      "#!/bin/bash\n"
      "# Submits the work of one plan to Slurm: a job array for each stage, then the link. What a\n"
      "# lost node left undone the next stage does first, so that no task has to end well.\n"
      "# usage: bash THIS_SCRIPT [options of sbatch, such as --partition=maps --mem=2G]\n"
      "set -euo pipefail\n"
      "mkdir -p " +
      shell_word(folder) +
      "\n"
      "submit() { sbatch --parsable --requeue --open-mode=append \"$@\"; }\n";
  std::string before;
  std::string finished;  // commands that finish the stages before
  for (const Stage stage : kWorkStages) {
    const std::string name(stage_name(stage));
    const std::string count = std::to_string(shares_of(job, stage));
    text += name + "=$(submit \"$@\" --job-name=sightline-" + name + " --array=1-" + count +
            " --output=" + logs + "/" + name + "-%a.log" +
            (before.empty() ? "" : " --dependency=afterany:$" + before) + " <<'TASK'\n" +
            "#!/bin/bash\nset -e\n" + finished + "exec " + work_command(job, stage) +
            " --share \"$SLURM_ARRAY_TASK_ID/" + count + "\"" + threads + "\nTASK\n)\n";
    finished += work_command(job, stage) + threads + "\n";
    before = name;
  }
  text += "link=$(submit \"$@\" --job-name=sightline-link --output=" + logs +
          "/link-%j.log --dependency=afterany:$" + before + " <<'TASK'\n#!/bin/bash\nset -e\n" +
          finished + "exec " + link_command(job) + "\nTASK\n)\n" + "echo \"$link\"\n";
  return text;
}

std::string make_script(const EngineJob& job) {
  const auto for_make = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('$', at)) != std::string::npos; at += 2) {
      text.insert(at, "$");
    }
    return text;
  };
  std::string rules;
  std::string before;
  for (const Stage stage : kWorkStages) {
    const int count = shares_of(job, stage);
    std::string stamps;
    for (int share = 1; share <= count; ++share) {
      const std::string number = std::to_string(share);
      const std::string target = "share-" + std::string(stage_name(stage)) + "-" + number;
      rules += ".PHONY: " + target + "\n" + target + ":" + before + "\n\t" +
               for_make(work_command(job, stage)) + " --share " + number + "/" +
               std::to_string(count) + " --threads 1\n";
      stamps += " " + target;
    }
    before = stamps;
  }
  return "# The work of one plan for GNU make: make -f THIS_FILE -j SHARES\n"
         "# Run it again after an interruption; what is finished is found.\n"
         ".DELETE_ON_ERROR:\n"
         ".PHONY: link\n"
         "link:" +
         before + "\n\t" + for_make(link_command(job)) + "\n" + rules;
}

// A string of Python.
std::string python_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

// A command in a rule of Snakemake, where braces alone are wildcards.
std::string rule_text(const std::string& command) {
  std::string text;
  for (const char c : command) {
    if (c == '{' || c == '}') text += c;
    text += c;
  }
  return python_text(text);
}

std::string snakemake_script(const EngineJob& job) {
  std::string rules;
  std::string finished;
  std::string before;
  for (const Stage stage : kWorkStages) {
    const std::string name(stage_name(stage));
    const std::string count = std::to_string(shares_of(job, stage));
    const std::string done =
        python_text("done/" + job.plan_digest + "/" + name + "-{share}-of-" + count);
    rules += "\nrule " + name + ":\n" + (before.empty() ? "" : "    input: " + before + "\n") +
             "    output: touch(" + done +
             ")\n    shell: " + rule_text(work_command(job, stage) + " --share ") +
             " \"{wildcards.share}/" + count + " --threads 1\"\n";
    finished += work_command(job, stage) + " && ";
    before = "expand(" + done + ", share=range(1, " + count + " + 1))";
  }
  return "# The work of one plan for Snakemake 7 and later: snakemake -s THIS_FILE --cores SHARES\n"
         "# Before it links it finishes what the shares left undone.\n"
         "workdir: " +
         python_text(job.plan.string()) + "\nrule link:\n    input: " + before +
         "\n    shell: " + rule_text(finished + link_command(job)) + "\n" + rules;
}

}  // namespace

std::vector<std::string> engine_names() { return {"slurm", "make", "snakemake"}; }

std::string engine_script(std::string_view engine, const EngineJob& job) {
  if (engine == "slurm") return slurm_script(job);
  if (engine == "make") return make_script(job);
  return snakemake_script(job);
}

}  // namespace sightline
