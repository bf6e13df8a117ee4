// Several accounts of what is measured. Whatever the prediction denies may be an outlier, or the
// prediction may be wrong: because the start was, or because the map was relocated. Each
// measurement that nothing explains founds a candidate, which is propagated on; later ones that the
// prediction denies too are offered to the candidates. Outliers do not agree with each other
// through what the IMU felt between them; a candidate that goes on agreeing is right. One that goes
// on where a prediction was given up before shows that what lay between was wrong, however well
// that agreed with itself.

#pragma once

#include "start.h"

namespace motorcade::filter {

// Two poses determine a candidate's pose and velocity, and nothing tests them but the turn between.
// Two more that agree are chance once in 10⁵ where turns are uniform; a fifth, since many are
// tried.
constexpr std::size_t enough_hits = 5;
// Of what is likely beforehand: that a prediction given up was right, or was worse than it said.
constexpr std::size_t enough_likely_hits = 3;
// A prediction that explained so many measurements knows the biases, unless it explains none any
// more for as long.
constexpr std::size_t established_hits = 4 * enough_hits;
// With half of the measurements wrong, one of so many in a row is right 98 times of 100.
constexpr std::size_t most_candidates = 6;
// How long the IMU alone may carry a prediction that was given up, as it may over gaps.
constexpr std::int64_t longest_bridge_ns = 10'000'000'000;

// How long measurements may agree on something else before it is no burst: twice as long as cameras
// are blind.
constexpr std::int64_t longest_burst_ns = 4'000'000'000;

// Deviations by which a position that the IMU tells is another than what is measured.
constexpr double told_apart = 3.0;

// A state that runs beside the filter's own.
template <std::size_t N> struct Track {
    State at;
    Matrix<N> covariance;
    std::int64_t time_ns = 0;
};

// Another account of what was measured, from the moment on at which it contradicted the prediction.
template <std::size_t N> struct Candidate {
    Track<N> track;
    std::size_t birth = 0;  // the event from which it started
    std::size_t hits = 0;   // measurements that it explained and the prediction did not
    bool agreed = false;    // with the latest one
    std::size_t base = 0;   // measurements that the prediction had explained at its birth
    bool returned = false;  // it goes on where a prediction was given up
    Doubt room;             // what the prediction needs to agree with its birth
};

// The path may begin at a pose that was denied near the start. Each start costs a pass over the
// whole: of all between so many seconds and twice as many the last is tried.
template <std::size_t N> void Timeline<N>::may_start(std::size_t index) {
    const auto octave = [&](std::size_t k) {
        return std::ilogb(static_cast<double>(events_[k].time_ns - events_.front().time_ns));
    };
    if (events_[index].time_ns - events_.front().time_ns > longest_bridge_ns) return;
    if (!starts_.empty() && octave(starts_.back()) == octave(index)) starts_.pop_back();
    starts_.push_back(index);
}

// A measurement was believed or denied: what follows for the prediction.
template <std::size_t N> void Timeline<N>::consider(std::size_t index) {
    const Event &event = events_[index];
    if (!event.measures() || index < begin_) return;
    if (former_ && event.time_ns - events_[former_->birth].time_ns > longest_bridge_ns)
        former_.reset();
    if (event.factor == 0.0) {
        if (event.relative) return;
        if (denied_++ == 0) {
            doubted_ns_ = event.time_ns;
            if (begin_ == 0 && event.from_pose()) may_start(index);
        }
        return challenge(index);
    }
    if (!event.placed) return;  // any map agrees with that
    denied_ = 0;
    ++explained_, ++own_hits_;
    const auto beaten = [this](const Candidate<N> &one) {
        return explained_ - one.base > one.hits;
    };
    candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), beaten),
                      candidates_.end());
}

template <std::size_t N> void Timeline<N>::challenge(std::size_t index) {
    const Event &event = events_[index];
    bool taken = false, returned = false;
    for (Candidate<N> &candidate : candidates_) {
        candidate.agreed = agrees(candidate, event);
        if (candidate.agreed) taken = true, returned |= candidate.returned;
    }
    if (former_ && !returned && former_->track.time_ns <= event.time_ns) {
        along(former_->track, [&] { advance_to(event.time_ns); });
        Candidate<N> again = *former_;
        again.hits = 0, again.base = explained_, again.birth = index;
        again.returned = again.agreed = true;
        // It may be worse than it says.
        if (agrees(again, event, settings_.most_noise)) taken = true, candidates_.push_back(again);
    }
    if (!taken) spawn(index);
    const auto fewer = [](const Candidate<N> &one, const Candidate<N> &other) {
        return one.agreed == other.agreed ? one.hits < other.hits : other.agreed;
    };
    const auto best = std::max_element(candidates_.begin(), candidates_.end(), fewer);
    if (best == candidates_.end() || !best->agreed) return;
    const bool likely = best->returned || strained(events_[best->birth]);
    if (best->hits < (likely ? enough_likely_hits : enough_hits) + (explained_ - best->base))
        return;
    // What explained twice as many is not given up lightly.
    if (!likely && own_hits_ >= 2 * best->hits && imu_suffices(event)) return;
    const Candidate<N> winner = *best;
    candidates_.clear();
    give_up(winner);
}

// Whether the IMU alone still tells the path well enough, from a prediction that was right for
// long. Measurements that agree on something else may be a burst of wrong ones, which is seen when
// it ends; if the map was relocated, waiting costs what such a gap costs. That is nothing while
// poses would not tell more, and less than to follow a burst while three deviations of what the IMU
// tells are nearer to it than what is measured.
template <std::size_t N> bool Timeline<N>::imu_suffices(const Event &event) const {
    if (own_hits_ < established_hits || event.time_ns - doubted_ns_ > longest_burst_ns)
        return false;
    if (bridged(p_, event)) return true;
    Innovation<N> innovation;
    if (!event.from_pose() || !Prediction<N>(now_, reading(time_ns_)).of(event, innovation))
        return false;
    double square = 0.0, apart = 0.0;
    for (std::size_t k = position; k < velocity; ++k) {
        square += p_.row[k][k];
        apart += innovation.residual[k] * innovation.residual[k];
    }
    return told_apart * told_apart * square <= apart;
}

// Whether the prediction of what was left out may just have been worse than it said, as after a
// long time without measurements.
template <std::size_t N> bool Timeline<N>::strained(const Event &event) const {
    return event.nis <= settings_.most_noise * settings_.gate[event.size];
}

// Does `act` with a track in the place of the filter's own state.
template <std::size_t N> template <class Do> void Timeline<N>::along(Track<N> &track, Do &&act) {
    const std::size_t sample = sample_;
    const auto exchange = [&] {
        std::swap(now_, track.at);
        std::swap(p_, track.covariance);
        std::swap(time_ns_, track.time_ns);
    };
    exchange();
    seek(time_ns_);
    act();
    exchange();
    sample_ = sample;
}

template <std::size_t N>
bool Timeline<N>::agrees(Candidate<N> &candidate, const Event &event, double gates) {
    bool hit = false;
    if (candidate.track.time_ns <= event.time_ns) {
        along(candidate.track, [&] {
            advance_to(event.time_ns);
            hit = believed(event, gates) > 0.0;
        });
    }
    candidate.hits += hit;
    return hit;
}

// Updates the state by a measurement if it lies within so many gates; its factor, or 0.
template <std::size_t N> double Timeline<N>::believed(const Event &event, double gates) {
    Innovation<N> innovation;
    Gain<N> gain;
    if (!predict(event, innovation) || !weigh(p_, innovation, 1.0, gain) ||
        !(gain.nis <= gates * settings_.gate[innovation.size]))
        return 0.0;
    apply(innovation, gain);
    return 1.0;
}

// A candidate that starts from a measurement: the prediction with room for that to be right, on a
// map that was relocated where it is a pose; from such a pose alone where the biases are not known.
template <std::size_t N> void Timeline<N>::spawn(std::size_t index) {
    const Event &event = events_[index];
    const bool fresh =
        event.from_pose() && (own_hits_ < established_hits || denied_ > established_hits);
    Candidate<N> spawned;
    spawned.track = {now_, p_, time_ns_};
    spawned.birth = index, spawned.hits = 1, spawned.base = explained_;
    const std::array<double, 5> &start = settings_.start_sigma;
    const auto square = [](double x) { return x * x; };
    std::array<double, 5> room = {square(wide_rad), square(wide_m), square(start[2]),
                                  square(bias_share * start[3]), square(bias_share * start[4])};
    if (!event.from_pose()) {
        Innovation<N> innovation;
        if (!Prediction<N>(now_, reading(time_ns_)).of(event, innovation)) return;
        double apart = 0.0;
        for (std::size_t a = 0; a < innovation.size; ++a) apart += square(innovation.residual[a]);
        const bool fast = event.kind == Kind::velocity,
                   seen = event.kind == Kind::corners || event.kind == Kind::sourced;
        room[0] = seen ? square(wide_rad) : 0.0;
        room[1] = fast ? 0.0 : std::max(seen ? square(wide_m) : 0.0, event.placed ? apart : 0.0);
        room[2] = std::max(apart, square(bias_share * start[2]));
    }
    spawned.room.relocated = event.from_pose();
    std::copy(room.begin(), room.end(), spawned.room.added);
    along(spawned.track, [&] {
        if (fresh) return from_pose(event);
        make_room(event, spawned.room);
        believed(event);
    });
    if (candidates_.size() == most_candidates) {
        const auto fewest =
            std::min_element(candidates_.begin(), candidates_.end(),
                             [](const Candidate<N> &one, const Candidate<N> &other) {
                                 return one.hits < other.hits;
                             });
        candidates_.erase(fewest);
    }
    candidates_.push_back(spawned);
}

// The winner's account is taken over, and all since is done again by it.
template <std::size_t N> void Timeline<N>::give_up(const Candidate<N> &winner) {
    const bool never_right = own_hits_ <= winner.hits;
    const Event &first = events_[winner.birth];
    const std::int64_t now_ns = events_[next_ - 1].time_ns;
    std::size_t from = winner.birth;
    undecide(never_right && own_birth_ > begin_ ? own_birth_ : winner.birth);
    if (winner.returned) {
        from = former_->birth;
        take_for_wrong(from, winner.birth);
        own_birth_ = former_->base, own_hits_ = former_->hits + winner.hits;
        former_.reset();
    } else if (never_right && own_birth_ == begin_ && !forgotten_) {
        from = begin_;
        events_[winner.birth].given = 1.0;
        judge_before(winner.track, winner.birth);
        own_hits_ = winner.hits;
    } else if (!never_right && strained(first)) {
        events_[winner.birth].given = std::max(1.0, first.nis / settings_.gate[first.size]);
        own_hits_ += winner.hits;
    } else {
        if (never_right && own_birth_ > begin_) {
            from = own_birth_;
            events_[from].doubt.reset();
            events_[from].given = undecided;
            if (former_) former_->birth = winner.birth;
        } else if (!former_ || former_->hits < own_hits_) {
            former_ = std::make_unique<Candidate<N>>(winner);
            former_->track = {now_, p_, time_ns_};
            former_->hits = own_hits_, former_->base = own_birth_;
        }
        events_[winner.birth].doubt = std::make_unique<Doubt>(winner.room);
        events_[winner.birth].given = 1.0;
        own_birth_ = winner.birth, own_hits_ = winner.hits;
    }
    given_up_.push_back({events_[from].time_ns, now_ns});
    for (std::size_t k = from; k < next_; ++k) events_[k].left_out = {nan_d, nan_d};
    denied_ = 0;
    replay(from, next_);
}

// A map that was relocated shortly before the end: the old one never had the time to come back. The
// IMU carries the path to the end on either account, and where it does so within what the gate
// allows a pose to be off, the old map is safe whichever is right.
template <std::size_t N> void Timeline<N>::doubt_last_jump(std::size_t since) {
    if (!former_ || former_->birth < since) return;
    std::size_t last = next_ - 1;  // samples may go on for long after it
    while (!events_[last].measures()) --last;
    along(former_->track, [&] { advance_to(events_[last].time_ns); });
    if (bridged(former_->track.covariance, events_[former_->birth]))
        undo_jump(former_->birth, former_->birth, next_);
}

// The same at the start: backward from the first relocation, by the state that all made of it.
template <std::size_t N> bool Timeline<N>::doubt_first_jump(std::size_t jump, Track<N> after) {
    if (!bridged_back(jump, begin_, after)) return false;
    restart(after.at);
    undo_jump(jump, begin_, jump);
    return true;
}

// Whether the IMU alone leads from the state after an event back to an earlier one, as well as
// poses would; the state becomes that there.
template <std::size_t N>
bool Timeline<N>::bridged_back(std::size_t from, std::size_t to, Track<N> &after) {
    along(after, [&] {
        turn_round();
        retreat_to(events_[to].time_ns);
        turn_round();
    });
    return bridged(after.covariance, events_[from]);
}

template <std::size_t N>
bool Timeline<N>::bridged(const Matrix<N> &covariance, const Event &event) const {
    double square = 0.0, measured = 0.0;
    if (!event.from_pose()) return false;
    for (std::size_t k = position; k < velocity; ++k) {
        square += covariance.row[k][k];
        measured += event.noise[7 * k];
    }
    return square <= settings_.gate[6] * measured;
}

template <std::size_t N> void Timeline<N>::take_for_wrong(std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
        events_[k].doubt.reset();
        if (events_[k].placed) events_[k].given = 0.0, events_[k].by_later = false;
    }
}

// What looking back made of these held for the prediction that is given up.
template <std::size_t N> void Timeline<N>::undecide(std::size_t from) {
    for (std::size_t k = from; k < next_; ++k)
        if (events_[k].by_later) events_[k].given = undecided;
}

// Takes a jump back, and all in [from, to) for wrong.
template <std::size_t N>
void Timeline<N>::undo_jump(std::size_t jump, std::size_t from, std::size_t to) {
    given_up_.push_back({events_[from].time_ns, events_[to - 1].time_ns});
    take_for_wrong(from, to);
    if (jump == to) events_[jump].given = undecided;
    events_[jump].doubt.reset();
    former_.reset();
    replay(from, next_);
}

// What was measured before a track's birth, judged by it against the flow of time: rate and
// velocity change their signs, force does not, and the same transitions hold. How many poses agree.
template <std::size_t N> std::size_t Timeline<N>::judge_before(Track<N> track, std::size_t birth) {
    std::size_t agreeing = 0;
    along(track, [&] {
        for (std::size_t k = birth + 1; k-- > begin_;) {
            Event &event = events_[k];
            turn_round();
            retreat_to(event.time_ns);
            turn_round();
            if (k == birth || !event.measures() || event.relative) continue;
            event.given = believed(event);
            agreeing += event.given > 0.0 && event.from_pose();
        }
        restart(now_);
    });
    return agreeing;
}

// The state as it is against the flow of time.
template <std::size_t N> void Timeline<N>::turn_round() {
    for (std::size_t i = 0; i < 3; ++i)
        now_.velocity[i] = -now_.velocity[i], now_.bias[i] = -now_.bias[i];
    for (std::size_t i = velocity; i < accel; ++i)
        for (std::size_t k = 0; k < N; ++k) p_.row[i][k] = -p_.row[i][k];
    for (std::size_t i = velocity; i < accel; ++i)
        for (std::size_t k = 0; k < N; ++k) p_.row[k][i] = -p_.row[k][i];
}

// Against the flow of time, with rate, velocity and the gyroscope's bias turned round.
template <std::size_t N> void Timeline<N>::retreat_to(std::int64_t to) {
    double fall[3];
    motion_.gravity(now_, fall);
    if (sample_ + 1 == samples_.size() && sample_ > 0) --sample_;
    while (time_ns_ > to) {
        if (samples_[sample_].time_ns >= time_ns_) --sample_;
        const Sample one = samples_[sample_], next = samples_[sample_ + 1];
        const std::int64_t begin = std::max(to, one.time_ns);
        const Reading here = reading(begin), there = reading(time_ns_);
        Reading mean;
        for (int i = 0; i < 3; ++i) {
            mean.rate[i] = -0.5 * (here.rate[i] + there.rate[i]);
            mean.force[i] = 0.5 * (here.force[i] + there.force[i]);
        }
        const double whole = 1e-9 * static_cast<double>(time_ns_ - begin);
        const int parts = Motion::parts(now_, mean, whole);
        for (int k = 0; k < parts; ++k) {
            Transition transition;
            motion_.step<N>(now_, mean, whole / parts, fall, transition);
            propagate(p_, transition, densities(next.time_ns - one.time_ns));
        }
        time_ns_ = begin;
    }
}

// Measurements were judged again: a candidate that was born of one that is believed now has no
// case.
template <std::size_t N> void Timeline<N>::reconsider() {
    const auto idle = [this](const Candidate<N> &one) { return events_[one.birth].factor > 0.0; };
    candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), idle),
                      candidates_.end());
    std::size_t last = next_;
    while (last > 0 && !(events_[last - 1].measures() && events_[last - 1].placed)) --last;
    if (last > 0 && events_[last - 1].factor > 0.0) denied_ = 0;
}

// Events were put in at an index, or forgotten there.
template <std::size_t N> void Timeline<N>::shift_candidates(std::size_t index, int by) {
    const auto shifted = [&](std::size_t k) {
        return k < index ? k : static_cast<std::size_t>(static_cast<std::ptrdiff_t>(k) + by);
    };
    const auto forgotten = [&](const Candidate<N> &one) { return by < 0 && one.birth <= index; };
    candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), forgotten),
                      candidates_.end());
    if (former_ && forgotten(*former_)) former_.reset();
    for (Candidate<N> &one : candidates_) one.birth = shifted(one.birth);
    if (former_) former_->birth = shifted(former_->birth), former_->base = shifted(former_->base);
    own_birth_ = shifted(own_birth_);
    if (by < 0)
        due_ = std::max<std::size_t>(due_, 2) - 1;  // what all go on from is settled
    else if (index < due_)
        ++due_;
}

}  // namespace motorcade::filter
