#pragma once
// Errors as values. A Result<T> is either a T or an Error; functions at the public edge return it for bad input and
// environment. Bugs are asserts, expected misses are std::optional. The library never prints and never exits.

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace spinel {

// One clear sentence: where (file, or file:line:column), what was found, what is allowed.
struct Error {
    std::string message;
};

template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::move(value)) {}
    Result(Error error) : state_(std::move(error)) {}
    explicit operator bool() const { return std::holds_alternative<T>(state_); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(value()); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    const Error& error() const {
        assert(!*this);
        return std::get<Error>(state_);
    }

  private:
    T& value() {
        assert(*this);
        return std::get<T>(state_);
    }
    const T& value() const {
        assert(*this);
        return std::get<T>(state_);
    }
    std::variant<T, Error> state_;
};

// Success without a value.
template <>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}
    explicit operator bool() const { return !error_; }
    const Error& error() const {
        assert(error_);
        return *error_;
    }

  private:
    std::optional<Error> error_;
};

}  // namespace spinel
