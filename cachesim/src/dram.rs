//! STUB
#![allow(missing_docs)]
use crate::error::Error;
use std::collections::VecDeque;
#[derive(Clone,Debug)] pub struct DramStandard;
impl DramStandard { pub fn builtin(_n:&str)->Option<Result<Self,Error>>{Some(Ok(Self))} }
#[derive(Clone,Debug)] pub struct DramConfig{pub standard:DramStandard,pub channels:u32,pub bytes_per_second:f64,pub queue:u32}
#[derive(Clone,Copy,Debug)] pub struct Done{pub at_ps:u64,pub tag:u32}
#[derive(Clone,Copy,Debug,Default,PartialEq,Eq)] pub struct DramCounts{pub reads:u64,pub writes:u64}
#[derive(Debug)] pub struct Dram{free:u64,ps_per_byte:f64,q:VecDeque<Done>,c:DramCounts}
impl Dram{
 pub fn new(c:&DramConfig)->Result<Self,Error>{Ok(Self{free:0,ps_per_byte:1e12/c.bytes_per_second,q:VecDeque::new(),c:DramCounts::default()})}
 pub fn idle_read_latency_ps(&self)->u64{40_000}
 pub fn submit(&mut self,now:u64,_a:u64,b:u32,w:bool,tag:u32){ if w{self.c.writes+=1}else{self.c.reads+=1}; let s=self.free.max(now); self.free=s+(f64::from(b)*self.ps_per_byte) as u64; self.q.push_back(Done{at_ps:s+40_000,tag}); }
 pub fn next_event(&self)->Option<u64>{self.q.front().map(|d|d.at_ps)}
 pub fn advance(&mut self,until:u64,out:&mut Vec<Done>){ while self.q.front().is_some_and(|d|d.at_ps<=until){ out.extend(self.q.pop_front()); } }
 pub fn counts(&self)->DramCounts{self.c}
}
