#pragma once
// The program as its users meet it: a child process with its exit code and both of its streams.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"
#include "formats/test_files.h"

namespace spinel {

struct Outcome {
    int code = -1;  // −1: ended by a signal, or by our patience
    std::string out, err;
};

// A running program. Its streams go to files, which never fill up as pipes do.
class Child {
  public:
    Child(const std::vector<std::string>& arguments, std::filesystem::path folder) : folder_(std::move(folder)) {
        std::vector<std::string> words = {SPINEL_PROGRAM};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        const int flags = O_WRONLY | O_CREAT | O_TRUNC;
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, (folder_ / "stdout").c_str(), flags, 0600);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (folder_ / "stderr").c_str(), flags, 0600);
        if (posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
        posix_spawn_file_actions_destroy(&actions);
        EXPECT_GT(pid_, 0) << "cannot start " << argv[0];
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child() {
        if (pid_ <= 0) return;
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }

    void send(int signal) const { ::kill(pid_, signal); }

    Outcome wait(double patience = 120) {
        using namespace std::chrono;
        const auto end = steady_clock::now() + duration<double>(patience);
        int status = 0;
        while (pid_ > 0 && ::waitpid(pid_, &status, WNOHANG) == 0) {
            if (steady_clock::now() > end) {
                ADD_FAILURE() << "the program still runs after " << patience << " s";
                ::kill(pid_, SIGKILL);
                ::waitpid(pid_, &status, 0);
                break;
            }
            std::this_thread::sleep_for(milliseconds(2));
        }
        pid_ = -1;
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, bytes_of(folder_ / "stdout"),
                bytes_of(folder_ / "stderr")};
    }

  private:
    std::filesystem::path folder_;
    pid_t pid_ = -1;
};

// Gives every test a folder for inputs and outputs, and another for the streams.
class ProgramTest : public FileTest {
  protected:
    void SetUp() override {
        FileTest::SetUp();
        std::filesystem::remove_all(folder);
        folder += "_" + std::to_string(::getpid());  // so that two builds may be tested at once
        streams_ = folder;
        streams_ += "_streams";
        for (const auto& path : {folder, streams_}) {
            std::filesystem::remove_all(path);
            std::filesystem::create_directories(path);
        }
    }
    void TearDown() override {
        FileTest::TearDown();
        std::filesystem::remove_all(streams_);
    }

    Child start(const std::vector<std::string>& arguments) const { return Child(arguments, streams_); }
    Outcome run(const std::vector<std::string>& arguments) const { return start(arguments).wait(); }

    std::string at(const std::string& name) const { return (folder / name).string(); }

    // Names in the folder, hidden ones too.
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
        std::sort(names.begin(), names.end());
        return names;
    }

  private:
    std::filesystem::path streams_;
};

// One line on stderr that begins with the program's name and says `why`; nothing on stdout.
inline void expect_complaint(const Outcome& outcome, int code, const std::string& why) {
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("spinel: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with("\n")) << outcome.err;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "");
}

// A small scene: a matte sphere of radius 1 at the origin under a white sky. `more` are further members, each
// with its comma in front.
inline std::string sphere_scene(const std::string& more = "") {
    return R"({"version": 1,
 "camera": {"from": [0, 0, 5], "at": [0, 0, 0], "fov": 30},
 "film": {"size": [24, 16]},
 "integrator": {"spp": 4},
 "environment": {"type": "constant", "radiance": 1},
 "materials": {"matte": {"type": "diffuse", "color": 0.5}},
 "objects": [{"geometry": {"type": "sphere", "radius": 1}, "material": "matte"}])" +
           more + "}\n";
}

}  // namespace spinel
